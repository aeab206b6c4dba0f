// A recording that was dropped here: its channels, what looks wrong in them, life and causes.

import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { ReportBlocks } from "./Blocks";
import { Card, Select } from "./Card";
import { CellMap } from "./CellMap";
import { formatFixed, formatNumber } from "./format";
import { JobButton } from "./SpeedView";
import { isDatabase, store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Channel, Heard, Lived } from "./types";
import { useRetainedState } from "./hooks";

export type FaultRule = "mask" | "accept" | "";

export function Recording({ known }: { known: AppState }) {
  const p = known.parcel;
  const whole = p !== null && p.got === p.size;
  const come = whole && !isDatabase(p.name);
  useEffect(() => { if (come) store.work("recording", {}, ""); }, [p?.id, come, known.lang]);
  const job = known.jobs.recording as Job<Heard> | undefined;
  const of = come ? job?.answer : null;
  const take = (files: FileList | null | undefined): void => { if (files?.length) store.take([...files]); };
  return (
    <>
      <section class="card drop" aria-labelledby="recording" onDragOver={(e) => e.preventDefault()} onDrop={(e) => { e.preventDefault(); take(e.dataTransfer?.files); }}>
        <header>
          <h2 id="recording">{t("Recording")}</h2>
          <label class="pick">{t("choose a file")}<input type="file" multiple data-field="recording" onChange={(e) => { const box = e.currentTarget as HTMLInputElement; take(box.files); box.value = ""; }} /></label>
          <span class="note">{t("or drop it here, up to 256 MB, a CAN log with its .dbc; it stays on this machine")}</span>
        </header>
        {!p && <EmptyRecording known={known} />}
        {p && whole && !come && <p class="note" role="status">{t("{file}: now the log whose frames it decodes", { file: p.name })}</p>}
        {p && !whole && <p class="note" role="status">{p.name} <progress max={p.size} value={p.got} aria-label={p.name} /></p>}
        {job?.running && <p class="note" role="status">{t("reading …")}</p>}
        {come && job?.why && <p class="fail">{job.why}</p>}
        {of && <p><b>{of.name}</b>: {t("{seconds} s at {rate} Hz, {count} channels", { seconds: formatNumber(of.seconds), rate: formatNumber(of.rate), count: of.channels.length + of.left })}</p>}
        {of?.notes.map((n) => <p key={n} class="note">{n}</p>)}
      </section>
      {of && p && <Asked key={p.id} of={of} known={known} />}
    </>
  );
}

const EXAMPLE = "time [s],gauge 1 [um/m],shaft speed [rpm]\n0.000,12.1,1480\n0.001,14.8,1480\n0.002,11.9,1481";

/** What a recording looks like, and which formats cannot be read as installed: said before a file is dropped. */
function EmptyRecording({ known }: { known: AppState }) {
  return (
    <>
      <p>{t("A CSV needs nothing more: a heading with units, then a row a sample.")}</p>
      <pre tabindex={0}>{EXAMPLE}</pre>
      {known.missing.filter((m) => m.extra !== "bracket").map((m) => <p key={m.use} class="note warn">{t("{formats} files cannot be read yet: pip install 'cardan[{extra}]', then start again", { formats: m.use, extra: m.extra })}</p>)}
    </>
  );
}

/** The first channel of each role but gauges, of which all are. */
const guessed = (of: Heard): Record<string, Channel["role"]> => {
  const taken = new Set<string>();
  return Object.fromEntries(of.channels.map((c): [string, Channel["role"]] => {
    const free = c.role === "gauge" || (!taken.has(c.role) && !(c.role === "tacho" && of.channels.some((o) => o.role === "speed")));
    taken.add(c.role);
    return [c.name, free ? c.role : ""];
  }));
};

function Asked({ of, known }: { of: Heard; known: AppState }) {
  const mine = `recording/${known.parcel?.id}`;
  const [roles, setRoles] = useRetainedState(`${mine}/roles`, guessed(of));
  const [rules, setRules] = useRetainedState<Record<string, FaultRule>>(`${mine}/rules`, {});
  const [typed, type] = useRetainedState<Record<string, string>>(`${mine}/typed`, {});
  const value = (key: string): string => (typed[key] ?? "").trim();
  const seconds = (key: string): number => Number(value(key).replace(/\s/g, "").replace(",", ".")) || 0;
  const named = (role: Channel["role"]): string => of.channels.find((c) => roles[c.name] === role)?.name ?? "";
  const gauges = of.channels.filter((c) => roles[c.name] === "gauge");
  const used = (c: Channel): boolean => roles[c.name] !== "";
  // A kind before its places: what is said of one of them counts.
  const ruled = (rule: FaultRule): string[] => Object.keys(rules).filter((key) => rules[key] === rule && of.channels.some((c) => used(c) && key.startsWith(`${c.name}=`))).sort();
  // As they were typed: which number that is says who reads those of the forms, or asks.
  const numbers = Object.fromEntries(["amplitude", "cycles", "slope", "first", "last", "hours", "modulus"].map((key) => [key, value(key)]));
  const args = {
    gauges: gauges.map((c) => c.name), speed: named("speed"), tacho: named("tacho"), torque: named("torque"), engine: named("engine"),
    mask: ruled("mask"), accept: ruled("accept"), zero: typed.zero ?? "none", ...numbers,
  };
  const job = known.jobs.life as Job<Lived> | undefined;
  const [open, opens] = useRetainedState<NonNullable<Lived["open"]>>(`${mine}/open`, []);
  useEffect(() => opens([...open, ...(job?.answer?.open ?? []).filter((o) => !open.some((was) => was.rule === o.rule))]), [job?.answer]);
  // Each but a gauge's is one channel's.
  const become = (name: string, role: Channel["role"]): void => setRoles(Object.fromEntries(Object.entries({ ...roles, [name]: role }).map(([n, r]) => [n, n !== name && r === role && role !== "gauge" ? "" : r])));
  const box = (key: string, label: string, hint = "") => (
    <label>{label}<input data-field={key} inputMode="decimal" placeholder={hint} value={typed[key] ?? ""} onInput={(e) => type({ ...typed, [key]: e.currentTarget.value })} /></label>
  );
  const [first, last] = [seconds("first"), seconds("last") || of.seconds];
  return (
    <div class="columns">
      <div class="left">
        <ChannelList of={of} between={[first, last]} rules={rules} used={used} decide={(of, rule) => setRules({ ...rules, [of]: rule })}>
          {(c) => (
            <Select label={t("type of {channel}", { channel: c.name })} value={roles[c.name] ?? ""} choose={(role) => become(c.name, role as Channel["role"])} of={Object.entries(roleNames())} />
          )}
        </ChannelList>
      </div>
      <div class="right">
        <Card id="asks" title={t("Life and causes")} head={<JobButton job={job} name="life" word={t("evaluate")} stale={job?.of !== store.about(args, "")} ask={() => store.work("life", args, "")} disabled={!gauges.length || ["amplitude", "cycles", "slope"].some((key) => !value(key))} />}>
          <fieldset class="fields"><legend class="note">{t("S-N curve at the gauge, half failed, at its knee")}</legend>{box("amplitude", t("amplitude [MPa]"))}{box("cycles", t("cycles"), "2e6")}{box("slope", t("slope"), "5")}{box("modulus", t("Young's modulus [GPa]"), "206")}</fieldset>
          <fieldset class="fields"><legend class="note">{t("Segment, and required life")}</legend>{box("first", t("from [s]"), "0")}{box("last", t("to [s]"), formatFixed(of.seconds, 0))}{box("hours", t("hours to live"))}
            <label>{t("taken off as zero")}<Select data-field="zero" value={typed.zero ?? "none"} choose={(zero) => type({ ...typed, zero })} of={[["none", t("nothing")], ["start", t("the start")], ["median", t("the median")], ["drift", t("a slow drift")]]} /></label>
          </fieldset>
          {open.map((o) => <label key={o.rule} class="suspect">{o.said} <Decide of={o.rule} free={t("undecided")} mask={o.mask} rules={rules} decide={(of, rule) => setRules({ ...rules, [of]: rule })} /></label>)}
        </Card>
        {job?.answer && <RecordingResult of={job.answer} known={known} />}
      </div>
    </div>
  );
}

export const roleNames = (): Record<Channel["role"], string> => ({ gauge: t("gauge"), speed: t("shaft speed"), torque: t("shaft torque"), engine: t("engine speed"), tacho: t("tacho"), "": "–" });

/** A rule of one place is that of what begins there, to a microsecond. */
const at = (kind: string, a: number): string => `${kind}@${Math.max(0, a - 1e-6).toFixed(6)}..${(a + 1e-6).toFixed(6)}`;

/** Channels over time, and what looks wrong in those of gauges, to be decided. */
/** What something that looks wrong was. */
const Decide = (p: { of: string; free: string; mask: boolean; rules: Record<string, FaultRule>; decide: (of: string, rule: FaultRule) => void }) => (
  <Select data-rule={p.of} value={p.rules[p.of] ?? ""} choose={(rule) => p.decide(p.of, rule as FaultRule)} of={[["", p.free], ...(p.mask ? [["mask", t("mask: no part felt it")] as const] : []), ["accept", t("accept: the part felt it")]]} />
);

export function ChannelList(p: { of: Heard; between: [number, number]; rules: Record<string, FaultRule>; used: (c: Channel) => boolean; decide: (of: string, rule: FaultRule) => void; children: (c: Channel) => ComponentChildren }) {
  const { of, rules } = p;
  const decide = (key: string, free: string, mask: boolean) => <Decide of={key} free={free} mask={mask} rules={rules} decide={p.decide} />;
  return (
    <Card id="channels" title={t("Channels")} head={of.left > 0 && <span class="note">{t("not shown: {count}", { count: of.left })}</span>}>
      <ul>
        {of.channels.map((c) => (
          <li key={c.name}>
            <p><b>{c.name}</b> <span class="note">{c.unit && `[${c.unit}]`} {formatNumber(c.low)} … {formatNumber(c.high)}</span> {p.children(c)}</p>
            <Trace of={c} used={p.used(c)} seconds={of.seconds} between={p.between} rules={rules} />
            {p.used(c) && c.suspects.map((s) => (
              <div key={s.kind}>
                <label class="suspect">{s.said} × {s.count} {decide(`${c.name}=${s.kind}`, t("undecided"), s.mask)} {s.count === 1 && s.places.map(([a = 0]) => `${formatFixed(a, 2)} s`)}</label>
                {s.count > 1 && <details class="note"><summary>{t("one by one")}{s.count > s.places.length && `: ${s.places.length} / ${s.count}`}</summary>{s.places.map(([a = 0, z = 0]) => <label key={a} class="suspect">{formatFixed(a, 3)} … {formatFixed(z, 3)} s {decide(`${c.name}=${at(s.kind, a)}`, t("as the others"), s.mask)}</label>)}</details>}
              </div>
            ))}
            {c.said.map((said) => <small key={said} class="note">{said}</small>)}
          </li>
        ))}
      </ul>
    </Card>
  );
}

/** Smallest and largest values over time, with what looks wrong, and what is left out. */
function Trace({ of, used, seconds, between, rules }: { of: Channel; used: boolean; seconds: number; between: [number, number]; rules: Record<string, FaultRule> }) {
  const n = of.highest.length;
  const [low, high] = [of.low ?? 0, of.high ?? 1];
  const y = (v: number | null | undefined): string => (38 - (36 * ((v ?? low) - low)) / (high - low || 1)).toFixed(1);
  const x = (s: number): number => (400 * s) / (seconds || 1);
  const edge = (values: Channel["lowest"], k: number): string => `${((400 * (k + 0.5)) / n).toFixed(1)} ${y(values[k])}`;
  const path = `M${of.highest.map((_, k) => edge(of.highest, k)).join("L")}L${of.lowest.map((_, k) => edge(of.lowest, n - 1 - k)).join("L")}Z`;
  return (
    <svg class="trace" viewBox="0 0 400 40" preserveAspectRatio="none" role="img" aria-label={t("{channel} over time", { channel: of.name })}>
      {used && of.suspects.flatMap((s) => s.places.map(([a = 0, b = 0]) => <rect key={`${s.kind}${a}`} class={rules[`${of.name}=${at(s.kind, a)}`] || rules[`${of.name}=${s.kind}`] || "open"} x={x(a)} y={0} width={Math.max(1.5, x(b) - x(a))} height={40} />))}
      <path d={path} />
      <rect class="out" x={0} y={0} width={x(Math.max(0, between[0]))} height={40} /><rect class="out" x={x(between[1])} y={0} width={Math.max(0, 400 - x(between[1]))} height={40} />
    </svg>
  );
}

/** What was answered; its verdict is open, and one chapter may be. */
export function RecordingResult({ of, known, open }: { of: Lived; known: AppState; open?: number }) {
  const [gauge, choose] = useState(0);
  const [at, setAt] = useState<[number, number]>([0, 0]);
  const map = of.orders[Math.min(gauge, of.orders.length - 1)];
  const top = Math.max(1e-9, ...(map?.MPa.flat().map((v) => v ?? 0) ?? []));
  const middle = (edges: number[], k: number): number => ((edges[k] ?? 0) + (edges[k + 1] ?? 0)) / 2;
  const [r, c] = map && at[0] < map.MPa.length ? at : [0, 0];
  return (
    <>
      <Card id="lived" title={of.name} head={<><b class={of.grade}>{of.verdict}</b><span class="note">{of.summary}</span></>}>
        {of.causes.length > 0 && <Removed of={of.causes} />}
      </Card>
      {map && (
        <Card id="orders" kind="" title={t("Amplitude over speed and order")}>
          <div class="chips" role="group" aria-label={t("gauge")}>{of.orders.map((o, k) => <button key={o.gauge} aria-pressed={o === map} onClick={() => choose(k)}>{o.gauge}</button>)}</div>
          <CellMap
            label={t("Amplitude by order and speed: choose with the arrow keys")} x={map.order} y={map.rpm} up height={260} theme={known.theme}
            grades={map.MPa.map((row) => row.map((v) => (v === null ? null : 0)))} among={["accent"]}
            strength={(row, k) => Math.max(0.02, 1 + Math.log10(Math.max(map.MPa[row]?.[k] ?? 0, 1e-9) / top) / 2.5)}
            at={[r, c]} choose={(row, k) => setAt([row, k])}
            said={`${t("order {order}", { order: formatNumber(middle(map.order, c)) })}, ${formatNumber(middle(map.rpm, r))} rpm: ${formatNumber(map.MPa[r]?.[c])} MPa`}
          />
          <p class="ends note"><span>0</span><span>{t("order of the shaft")} →, ↑ {formatNumber(map.rpm[0])} … {formatNumber(map.rpm.at(-1))} rpm</span><span>{formatNumber(map.order.at(-1))}</span></p>
          <p class="note">{t("Shaft orders are vertical, natural modes are inclined; darkness in powers of ten.")}</p>
        </Card>
      )}
      {of.chapters.map((ch, k) => <details key={ch.title} class="card more" open={k === 0 || open === k}><summary>{ch.title}</summary><ReportBlocks of={ch.blocks} /></details>)}
    </>
  );
}

/** What would go with the joints at each gauge, with its interval of 90 %. */
function Removed({ of }: { of: Lived["causes"] }) {
  const x = (share: number): number => 4 + 2.9 * Math.max(-1, Math.min(101, 100 * share));
  return (
    <ul class="removed">
      {of.map((c) => (
        <li key={c.gauge}>
          <p><b>{c.gauge}</b>: {t("{share} % of the damage would go with the joints (90 % interval {low} to {high} %): {finding}", { share: formatFixed(100 * c.removed, 0), low: formatFixed(100 * c.low, 0), high: formatFixed(100 * c.high, 0), finding: c.said })}</p>
          <svg viewBox="0 0 300 14" role="img" aria-label={`${formatFixed(100 * c.low, 0)} … ${formatFixed(100 * c.high, 0)} %`}>
            <path class="axes" d={`M${x(0)} 12H${x(1)}`} /><rect x={x(c.low)} y="3" width={Math.max(2, x(c.high) - x(c.low))} height="7" /><circle cx={x(c.removed)} cy="6.5" r="4" />
          </svg>
          {c.shares.length > 0 && <p class="note">{c.shares.filter((s) => (s.share ?? 0) > 0.005).sort((a, b) => (b.share ?? 0) - (a.share ?? 0)).map((s) => `${s.said} ${formatFixed(100 * (s.share ?? 0), 0)} %`).join(" · ")}</p>}
        </li>
      ))}
    </ul>
  );
}
