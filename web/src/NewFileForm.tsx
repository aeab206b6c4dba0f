// From a protractor's readings, or a pasted table, to a file and its verdict.

import { useEffect, useState } from "preact/hooks";
import { Card, Select, DataTable } from "./Card";
import { formatFixed, formatNumber, marginText } from "./format";
import { store, type Job, type AppState } from "./store";
import { gradeText } from "./gradeLookup";
import { t } from "./i18n";
import type { Guided } from "./types";
import { useRetainedState } from "./hooks";

type Cells = Record<string, string>;
/** Characters of a pasted table, and of a field: the server takes no more. */
const MOST = 20_000;
const FIELD = 200;

/** What a part is called whose sizes are typed, not chosen: the server knows it by that name. */
const OWN = "own";

const EMPTY = {
  title: "", speed: "", torque: "", limits: "body-builder", joint: "", joint_name: "", joint_peak: "", joint_reversing: "", joint_bearing: "", joint_angle: "",
  engine_torque: "", engine_speed: "", ratios: "", reverse: "", wheelbase_from: "", wheelbase_to: "",
  unit: "mm", axes: "rear", points: "", members: [{}, {}, {}] as Cells[], shafts: [{}] as Cells[],
};
type Form = typeof EMPTY;

export function NewFileForm({ known }: { known: AppState }) {
  const [form, set] = useRetainedState<Form>("guide", EMPTY);
  const [pasting, paste] = useRetainedState("guide/pasting", false);
  const question = { ...form, points: pasting ? form.points : "" };
  useEffect(() => {
    if (pasting && form.points.length > MOST) return;
    const timer = setTimeout(() => store.work("guided", question, ""), 200);
    return () => clearTimeout(timer);
  }, [form, pasting, known.lang]);
  const job = known.jobs.guided as Job<Guided> | undefined;
  const wrong = new Map((job?.problems ?? []).map((p) => [p.key, p.message]));
  const change = (part: Partial<Form>): void => set({ ...form, ...part });
  const cell = (list: "members" | "shafts", k: number, key: string, value: string): void =>
    change({ [list]: form[list].map((row, i) => (i === k ? { ...row, [key]: value } : row)) });
  const count = (n: number): void => {
    const shafts = Array.from({ length: n }, (_, k) => form.shafts[k] ?? {});
    const members = [...form.members.slice(0, -1), ...Array<Cells>(Math.max(0, n + 1 - (form.members.length - 1))).fill({})];
    change({ shafts, members: [...members.slice(0, n + 1), form.members.at(-1) ?? {}] });
  };
  const fields: Record<string, string> = {};
  const field = (key: string, name: string, value: string, put: (v: string) => void, hint = "") => (fields[key] = name) && (
    <input value={value} placeholder={hint} inputMode={key === "joint_name" || key === "ratios" ? "text" : "decimal"} aria-label={name} data-field={key} aria-invalid={value !== "" && wrong.has(key)} title={wrong.get(key) ?? ""} maxLength={FIELD} onInput={(e) => put(e.currentTarget.value.slice(0, FIELD))} />
  );
  type Typed = "joint_name" | "joint_peak" | "joint_reversing" | "joint_bearing" | "joint_angle" | "engine_torque" | "engine_speed" | "ratios" | "reverse" | "wheelbase_from" | "wheelbase_to";
  const named = (key: Typed, name: string, hint = "") => (
    <label>{name}{field(key, name, form[key], (v) => change({ [key]: v }), hint)}</label>
  );
  const n = form.shafts.length;
  const names = [t("gearbox"), ...form.shafts.map((_, k) => t("shaft {n}", { n: k + 1 })), t("pinion")];
  const long = pasting && form.points.length > MOST;
  const of = job?.problems || long ? null : job?.answer;
  // An answer to what the form held before the last change is no verdict, and no file is made of it.
  const current = job !== undefined && !job.running && job.of === store.about(question, "");
  // What is empty yet is no mistake: it is asked for by its name.
  const typed = () => (job?.problems ?? []).filter((p) => !(p.key in fields && !p.value) && (p.key !== "points" || form.points));
  const missing = (): string => (job?.problems ?? []).filter((p) => !p.value).map((p) => fields[p.key]).filter(Boolean).join("; ");
  return (
    <div class="columns">
      <div class="left"><Card id="guide" title={t("From a protractor's readings")} note={t("slopes down to the rear are positive, to the right too")}>
        <div class="fields">
          <label>{t("title")}<input value={form.title} data-field="title" maxLength={300} onInput={(e) => change({ title: e.currentTarget.value.slice(0, 300) })} /></label>
          <label>{t("top speed [rpm]")}{field("speed", t("top speed [rpm]"), form.speed, (v) => change({ speed: v }))}</label>
          <label>{t("largest torque [N·m]")}{field("torque", t("largest torque [N·m]"), form.torque, (v) => change({ torque: v }))}</label>
          <label>{t("joints")}<Select value={form.joint} data-field="joint" choose={(joint) => change({ joint })} of={["", [OWN, t("own joint")], ...known.catalogue.joints.map((o) => o.name)]} /></label>
          <label>{t("shafts")}<Select value={String(n)} data-field="count" choose={(k) => count(Number(k))} of={["1", "2", "3", "4", "5", "6"]} /></label>
          <label>{t("lengths in")}<Select value={form.unit} choose={(unit) => change({ unit })} of={["mm", "in"]} /></label>
          <label>{t("limits")}<Select value={form.limits} data-field="limits" choose={(limits) => change({ limits })} of={known.profiles} /></label>
        </div>
        {form.joint === OWN && <fieldset class="fields"><legend class="note">{t("own joint")}</legend>{named("joint_name", t("name of the joint"))}{named("joint_peak", `${t("elastic limit")} [N·m]`)}{named("joint_reversing", `${t("fatigue")} [N·m]`)}{named("joint_bearing", `${t("bearings")} [N·m]`)}{named("joint_angle", t("largest angle [deg]"))}</fieldset>}
        <fieldset class="fields"><legend class="note">{t("engine and gears: the torque of each gear follows")}</legend>{named("engine_torque", t("engine torque [N·m]"))}{named("engine_speed", t("at engine speed [rpm]"))}{named("ratios", t("ratios, lowest gear first"), "6.7 3.8 2.3 1")}{named("reverse", t("reverse ratio"))}</fieldset>
        <fieldset class="fields"><legend class="note">{t("another wheelbase: a file of each")}</legend>{named("wheelbase_from", `${t("wheelbase before")} [${form.unit}]`)}{named("wheelbase_to", `${t("wheelbase after")} [${form.unit}]`)}</fieldset>
        <div class="chips" role="group" aria-label={t("The line by")}>
          <button aria-pressed={!pasting} onClick={() => paste(false)}>{t("slopes and lengths")}</button>
          <button aria-pressed={pasting} data-way="points" onClick={() => paste(true)}>{t("points, pasted from a spreadsheet")}</button>
        </div>
        {pasting && <PointsTableField form={form} change={change} invalid={wrong.has("points") || [...wrong.keys()].some((k) => k.startsWith("row"))} />}
        <DataTable label={t("From a protractor's readings")} head={["", t("side slope [deg]"), t("top slope [deg]"), ...(pasting ? [] : [`${t("length")} [${form.unit}]`]), `${t("bearing ahead of the rear joint")} [${form.unit}]`, t("phase [deg]"), t("tube"), ...(n > 1 ? [t("bearing stiffness, vertical [N/mm]"), t("bearing stiffness, lateral [N/mm]")] : [])]}>
          {names.map((name, k) => {
            const shaft = k > 0 && k <= n ? form.shafts[k - 1] : undefined;
            const put = (key: string, label: string, hint = "") => field(`shafts[${k}].${key}`, `${name}: ${label}`, shaft?.[key] ?? "", (v) => cell("shafts", k - 1, key, v), hint);
            const sloped = !pasting || !shaft;
            return (
              <tr key={k}>
                <th scope="row">{name}</th>
                {(["side", "top"] as const).map((view) => (
                  <td key={view}>{sloped && field(`members[${k + 1}].${view}`, `${name}: ${t(view === "side" ? "side slope [deg]" : "top slope [deg]")}`, form.members[k]?.[view] ?? "", (v) => cell("members", k, view, v))}</td>
                ))}
                {!pasting && <td>{shaft && put("length", t("length"))}</td>}
                <td>{shaft && k < n && put("bearing", t("bearing ahead of the rear joint"))}</td>
                <td>{shaft && put("phase", t("phase [deg]"))}</td>
                <td>{shaft && (
                  <Select label={`${name}: ${t("tube")}`} value={shaft.tube ?? ""} choose={(tube) => cell("shafts", k - 1, "tube", tube)} of={["", [OWN, t("own tube")], ...known.catalogue.tubes.map((o) => o.name)]} />
                )}{shaft?.tube === OWN && <span class="own">{put("outer", `${t("outer diameter")} [${form.unit}]`, "Ø")} × {put("wall", `${t("wall")} [${form.unit}]`, t("wall"))}</span>}</td>
                {n > 1 && (["vertical", "lateral"] as const).map((way) => <td key={way}>{shaft && k < n && put(way, t(way === "vertical" ? "bearing stiffness, vertical [N/mm]" : "bearing stiffness, lateral [N/mm]"))}</td>)}
              </tr>
            );
          })}
        </DataTable>
      </Card></div>
      <div class="right"><Card id="comes" kind={`guided ${(current && of?.verdict) || ""}`} title={t("Result")} head={of && (current ? <b class={of.verdict} role="status">{of.headline}</b> : <span class="pending" role="status">{job?.why || t("calculating …")}</span>)}>
        {!of && !long && <ul class="problems">{typed().map((p) => <li key={p.key + p.message} class="fail">{p.message} <i>{p.value}</i></li>)}</ul>}
        {!of && !long && typed().length === 0 && <p class="note">{t("Fill in the slopes and lengths: the verdict follows.")} {missing() && `${t("Still missing:")} ${missing()}`}</p>}
        {of && (
          <>
            <p class="facts">{of.angles.map((a, k) => <span key={k}>{t("joint {n}", { n: k + 1 })} <b>{formatFixed(a, 2)}°</b></span>)}<span>{t("equivalent angle")} <b>{formatFixed(of.equivalent, 2)}°</b></span></p>
            <ul class="others">
              {of.unanswered.map((u) => <li key={u}>{u}</li>)}
              {of.warnings.map((w) => <li key={w} class="warn"><b>{t("warning")}</b> {w}</li>)}
              {of.checks.map((c, k) => <CheckLine key={k} of={c} />)}
            </ul>
            {of.after && (
              <>
                <p><b>{t("wheelbase after")}</b> {form.wheelbase_to} {form.unit}: <b class={of.after.verdict}>{of.after.headline}</b></p>
                <ul class="others">{of.after.checks.map((c, k) => <CheckLine key={k} of={c} />)}</ul>
              </>
            )}
            <button class="make" disabled={!current} onClick={() => create(form, of)}>{of.after ? t("Make a file of each") : t("Make a file of it")}</button>
          </>
        )}
      </Card></div>
    </div>
  );
}

const CheckLine = ({ of: c }: { of: Guided["checks"][number] }) => (
  <li class={c.grade}><b>{gradeText(c.grade)}</b> {c.name}, {c.where}: {formatNumber(c.value)} ({c.limit}), {marginText(c.margin)}</li>
);

/** Write the file of a form; with two wheelbases one of each, and the later one is opened. */
function create(form: Form, of: Guided): void {
  const title = form.title || "driveline";
  if (!of.after) return store.create(title, of.draft);
  store.create(`${title} ${form.wheelbase_from}`, of.draft);
  store.create(`${title} ${form.wheelbase_to}`, of.after.draft);
}

/** A field that takes a table of points, in either of the axes they are drawn in. */
export function PointsTableField({ form, change, invalid }: { form: { points: string; axes: string }; change: (part: { points?: string; axes?: string }) => void; invalid: boolean }) {
  return (
    <div class="pasted">
      <textarea aria-label={t("x, y and z of every joint, a row each, gearbox first")} placeholder={t("x, y and z of every joint, a row each, gearbox first")} aria-invalid={invalid} value={form.points} rows={5} spellcheck={false} onInput={(e) => change({ points: e.currentTarget.value })} />
      {form.points.length > MOST && <p class="note fail" role="alert">{t("a table may have up to {count} characters: paste the joints' rows alone", { count: MOST })}</p>}
      <Select label={t("axes")} value={form.axes} choose={(axes) => change({ axes })} of={[["rear", t("x to the rear, y to the right, z up")], ["front", t("x ahead, y to the left, z up")]]} />
    </div>
  );
}

/** Points of the line that is shown, pasted over those it has. */
export function PastePointsForm({ known, line }: { known: AppState; line: number }) {
  const [form, set] = useState({ points: "", axes: "rear", unit: "mm" });
  const job = known.jobs.pasted as Job<{ edits: Record<string, number> }> | undefined;
  const edits = job?.running ? undefined : job?.answer?.edits;
  useEffect(() => { if (edits) store.taken("pasted", edits); }, [edits]);
  return (
    <details class="more paste">
      <summary>{t("Paste the joints' points from a spreadsheet")}</summary>
      <PointsTableField form={form} change={(part) => set({ ...form, ...part })} invalid={job?.why !== undefined && job.why !== ""} />
      <Select label={t("lengths in")} value={form.unit} choose={(unit) => set({ ...form, unit })} of={["mm", "in"]} />{" "}
      <button disabled={form.points.trim() === "" || form.points.length > MOST} onClick={() => store.work("pasted", { ...form, line })}>{t("insert")}</button>
      {job?.why && <p class="note fail">{job.why}</p>}
    </details>
  );
}
