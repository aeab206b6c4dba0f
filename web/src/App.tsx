// The page: what it is of, the verdict, the views, the limits.

import { useEffect, useState } from "preact/hooks";
import type { ComponentType } from "preact";
import { Campaign } from "./Campaign";
import { Card, Select } from "./Card";
import { CorrectionsView } from "./Corrections";
import { Drawing, type ShownLine } from "./Drawing";
import { YokePhaseDials } from "./YokePhaseDials";
import { Editor } from "./Editor";
import { formatNumber, marginText } from "./format";
import { NewFileForm } from "./NewFileForm";
import { atLeast, disclosed, LimitDetail, MarginHeatmap } from "./MarginHeatmap";
import { Suggestions } from "./Suggestions";
import { hasUnsavedEdits } from "./history";
import { Library, LibraryView } from "./Library";
import { Limits } from "./Limits";
import { partGrades, verdictText } from "./gradeLookup";
import { PartsTable } from "./Parts";
import { Phasors } from "./Phasors";
import { JointAngleTable, StatePicker } from "./StatePicker";
import { Recording } from "./Recording";
import { SpeedView } from "./SpeedView";
import { problemText, store, VIEWS, worstRank, worstPart, worstState, type AppState, type View } from "./store";
import { t } from "./i18n";
import type { Line, Row, Verdict } from "./types";
import { KeepVariantButton, Variants } from "./Variants";
import { memoisedCard, memoised, useAppState } from "./hooks";

type Both = { known: AppState; shown: ShownLine };

/** What is drawn of a line: where it runs, and what its limits make of that. */
const drawn = ({ known: k, shown: s }: Both): unknown[] => [s.line, s.laid, s.state, s.free, s.where, k.behind, k.jobs.ghost, k.variants, k.lang, k.fixed];
const StillViews = memoisedCard<Both>("views", Views, (p) => [...drawn(p), p.known.live?.obstacles, JSON.stringify(p.shown.marks), p.known.selected, p.known.held, p.known.handles, p.known.theme]);
const StillAngles = memoisedCard<Both>("angles", JointAngleTable, (p) => [...drawn(p), p.known.jobs, p.known.pose?.line, p.known.pose?.torque]);
const StillPhasors = memoisedCard<Both>("phasors", Phasors, drawn);
const judged = ({ known: k }: { known: AppState }): unknown[] => [k.live?.limits, k.live?.states, k.full, k.order, k.settled, k.unfinished, k.lang];
const StillStrip = memoised<{ known: AppState }>(Strip, (p) => [...judged(p), p.known.live?.profile, p.known.selected, p.known.view]);
const StillHeat = memoisedCard<{ known: AppState }>("heat", MarginHeatmap, (p) => [...judged(p), p.known.selected, p.known.asked.state ?? p.known.pose?.state]);
const StillHead = memoised<{ known: AppState }>(Head, ({ known: k }) => [k.history, named(k), k.files, k.file, k.connection, k.lang, k.theme, k.fixed]);

/** What a hand that moves something does not change: drawn again once it lets go. */
const rested = ({ known, shown }: Both): unknown[] => [known.held ? null : known.live, known.held ? null : known.full, known.pose, known.asked, known.theme, known.lang, shown.free, shown.state];
const StillPoser = memoised<Both>(StatePicker, rested);
const StillDials = memoised<Both>(YokePhaseDials, ({ known: k, shown: s }) => [k.held?.startsWith("phase/") ? s.line : k.held ? null : k.live, k.held, k.pose?.turn, k.theme, k.lang, s.index]);
const StillParts = memoised<Both>(PartsTable, ({ known: k, shown: s }) => [k.held ? null : k.live, JSON.stringify(s.marks), k.catalogue, k.lang]);
const StillEditor = memoised<{ known: AppState }>(Editor, ({ known: k }) => [k.history, k.problems, k.live?.warnings.length, k.lang, k.file]);
const StillHelps = memoised<{ known: AppState }>(Suggestions, ({ known: k }) => [k.helps, k.helping, k.full, k.settled, k.lang]);

export function App() {
  const known = useAppState();
  const shown = what(known);
  useKeys();
  useEffect(() => {
    const dirty = known.history !== null && hasUnsavedEdits(known.history);
    document.title = `${dirty ? "• " : ""}${named(known)}`;
  }, [named(known), known.history]);
  return (
    <>
      <StillHead known={known} />
      <main id="main">
        <Notices known={known} />
        {known.file === null && known.connection === "open" && <><Library known={known} /><NewFileForm known={known} /></>}
        {known.connection === "refused" && <p class="card note">{t("This page does not know the workbench: open the address that `cardan serve` printed.")}</p>}
        {shown && (
          <>
            {known.view !== "new" && <StillStrip known={known} />}
            {known.view !== "new" && known.selected?.inStrip && <LimitDetail known={known} />}
            {!known.fixed && <Tabs known={known} views={VIEWS} />}
            {known.view === "new" && <NewFileForm known={known} />}
            {known.view === "variants" && <Variants known={known} />}
            {known.view === "change" && <CorrectionsView key={shown.line.name} known={known} shown={shown} />}
            {known.view === "bracket" && <Later load={() => import("./Bracket")} known={known} />}
            {known.view === "recording" && <Recording known={known} />}
            {known.view === "limits" && <Limits known={known} />}
            {known.view === "library" && <LibraryView known={known} />}
            {known.view === "speed" && <SpeedView known={known} shown={shown} />}
            {known.view === "line" && <div class="columns">
              <div class="left">
                <StillViews known={known} shown={shown} />
                <StillPoser known={known} shown={shown} />
                <StillAngles known={known} shown={shown} />
                {!known.fixed && <StillParts known={known} shown={shown} />}
                {!known.fixed && <StillEditor known={known} />}
              </div>
              <div class="right">
                <StillHeat known={known} />
                {!known.fixed && <StillHelps known={known} />}
                <StillPhasors known={known} shown={shown} />
                {!known.fixed && <StillDials known={known} shown={shown} />}
              </div>
            </div>}
          </>
        )}
        {known.campaign && <Tabs known={known} views={["line", "variants", "library", "new"]} />}
        {known.campaign && (known.view === "library" ? <LibraryView known={known} /> : known.view === "new" ? <NewFileForm known={known} /> : known.view === "variants" ? <Variants known={known} /> : <Campaign known={known} of={known.campaign} />)}
        {!shown && !known.campaign && known.file !== null && known.history && (
          <>
            {known.problems.length > 0 && <p class="card note fail">{t("The file cannot be read as it is: see what is wrong below.")}</p>}
            <StillEditor known={known} />
          </>
        )}
      </main>
    </>
  );
}

/** What is open, by its title. */
const named = ({ live, campaign }: AppState): string => (live ?? campaign)?.title ?? "cardan";

/** The views of what is open; of an application the verdict stands above each. */
function Tabs({ known, views }: { known: AppState; views: readonly View[] }) {
  const names: Record<View, string> = { line: known.campaign ? t("Campaign") : t("Line"), speed: t("Speed"), change: t("What to change"), variants: t("Variants"), bracket: t("Bracket"), recording: t("Recording"), limits: t("Limits"), library: t("Reports, files"), new: t("New") };
  return (
    <nav class="tabs chips" aria-label={t("Views")}>
      {views.map((view) => (<button key={view} data-view={view} aria-pressed={known.view === view} onClick={() => store.show(view)}>{names[view]}</button>))}
    </nav>
  );
}

/** The line and state that are shown. */
function what(known: AppState): ShownLine | null {
  const { live, pose, asked } = known;
  if (!live) return null;
  const index = Math.min(asked.line ?? 0, live.lines.length - 1);
  const line = live.lines[index];
  if (!line) return null;
  const state = Math.min(asked.state ?? (pose?.line === index ? pose.state : null) ?? live.worst, live.states.length - 1);
  const free = (asked.travel_mm ?? asked.torque_Nm) !== undefined && pose?.at !== undefined && pose.line === index;
  const row = store.rows().find((r): r is Row => r.id === known.selected?.row);
  const where = !free ? live.states[state]?.said : asked.state === undefined ? t("at the sliders") : row?.points?.[state]?.[known.selected?.part ?? 0];
  const laid = free ? pose.at?.laid : line.states[state];
  return laid ? { live, line, index, state, laid, free, where: where ?? "", marks: partGrades(store.rows(), line.name, state) } : null;
}

function useKeys(): void {
  useEffect(() => {
    const heard = (e: KeyboardEvent): void => {
      if (!(e.ctrlKey || e.metaKey) || e.altKey) return;
      const typing = e.target instanceof HTMLTextAreaElement;
      const key = e.key.toLowerCase();
      if (key === "s") store.save();
      else if (key === "z" && !typing) e.shiftKey ? store.redo() : store.undo();
      else if (key === "y" && !typing) store.redo();
      else return;
      e.preventDefault();
    };
    addEventListener("keydown", heard);
    return () => removeEventListener("keydown", heard);
  }, []);
}

function Head({ known }: { known: AppState }) {
  const history = known.history;
  const dirty = history !== null && hasUnsavedEdits(history);
  const title = named(known);
  return (
    <header class="head">
      <a class="skip" href="#main">{t("to the page")}</a>
      <svg class="mark" viewBox="0 0 32 32" aria-hidden="true"><path d="M2 10 13 14m6 4 11 4" /><circle cx="16" cy="16" r="5" /></svg>
      <h1 title={title}>{title}</h1>
      {known.files.length > 1 && (
        <Select label={t("File")} value={String(known.file ?? "")} choose={(k) => store.open(Number(k))} of={[...(known.file === null ? [["", "…"] as const] : []), ...known.files.map((name, k) => [String(k), name] as const)]} />
      )}
      <div class="tools">
        {known.connection === "lost" && <span class="note fail" role="status">{t("connection lost")}</span>}
        {!known.fixed && <>
        <button disabled={!history?.past.length} onClick={() => store.undo()} title="Ctrl+Z" aria-label={t("undo")}>↶</button>
        <button disabled={!history?.future.length} onClick={() => store.redo()} title="Ctrl+Y" aria-label={t("redo")}>↷</button>
        <button class="save" disabled={!dirty} onClick={() => store.save()} title="Ctrl+S">{t("Save")}</button>
        </>}
        <Select label={t("Language")} value={known.lang} choose={(lang) => store.speak(lang)} of={known.languages} />
        <Select label={t("Colours")} value={known.theme} choose={(theme) => store.theme(theme as AppState["theme"])} of={[["auto", t("as the system")], ["light", t("light")], ["dark", t("dark")]]} />
      </div>
    </header>
  );
}

function Notices({ known }: { known: AppState }) {
  const n = known.notice;
  const unread = (known.live ?? known.campaign) !== null && known.problems.length > 0;
  const said = n && (n.kind === "refused" ? n.why : {
    restored: t("Unsaved changes of last time are restored; undo returns to the file."),
    elsewhere: t("Another page has unsaved edits of this file: they are shown here too; undo goes back to the file."),
    reloaded: t("The file was changed on disk, and is shown as it is now."),
    beside: t("A file that this one names was changed on disk; the verdict is computed again."),
    conflict: t("The file was changed on disk while there are unsaved edits here."),
  }[n.kind]);
  return (
    <div aria-live="polite">
      {n && (
        <p class={`notice ${n.kind === "conflict" ? "warn" : n.kind === "refused" ? "fail" : ""}`}>
          {said}
          {"left" in n && n.left > 0 && ` ${t("Unsaved changes of other pages are kept as variants.")}`}
          {n.kind === "conflict" ? (
            <>
              <button onClick={() => store.settle(true)}>{t("load the file; undo restores mine")}</button>
              <button onClick={() => store.settle(false)}>{t("overwrite with mine")}</button>
            </>
          ) : <button onClick={() => store.dismiss()}>{t("close")}</button>}
        </p>
      )}
      {unread && (<p class="notice fail">{t("Shown is the last that could be read: {why}", { why: known.problems.slice(0, 1).map(problemText).join() })}</p>)}
    </div>
  );
}

const SIGNS: Record<Verdict, string> = { pass: "✓", warn: "△", incomplete: "…", fail: "✗" };

function Strip({ known }: { known: AppState }) {
  const { full, live, settled, unfinished } = known;
  // A failure that is known at once is one, whatever comes after; nothing else is a verdict without the bearing forces.
  const failed = !settled && live?.grade === "fail";
  const verdict: Verdict | null = failed ? "fail" : unfinished ? "incomplete" : (full?.verdict ?? live?.grade ?? null);
  const decided = settled || failed || unfinished !== "";
  const bad = store.rows().filter((r): r is Row => r.values !== undefined && worstRank(r) < -0.5).sort((a, b) => worstRank(a) - worstRank(b));
  return (
    <section class={`strip ${decided ? (verdict ?? "") : ""} ${settled ? "" : "open"}`} aria-label={t("Verdict")}>
      <p class="verdict" role="status"><span aria-hidden="true">{verdict ? (decided ? SIGNS[verdict] : "…") : ""}</span> {verdict ? ((!unfinished && verdict === full?.verdict && full.headline) || verdictText(verdict)) : "…"}</p>
      <p class="counts">
        {full && !unfinished && (["fail", "warn", "pass"] as const).map((g) => <span key={g} class={g}>{full.counted[g]}</span>)}
        {full && !unfinished && full.missed > 0 && <span>{t("{count} not evaluated", { count: full.missed })}</span>}
        <span class="profile">{live?.profile}</span>
        <span class="pending" aria-hidden={settled}>{settled ? "" : unfinished ? t("bearing forces not evaluated: {why}", { why: unfinished }) : <><progress aria-hidden="true" /> {t("bearing forces follow …")}</>}</span>
        {unfinished && <button onClick={() => store.evaluateAgain()}>{t("evaluate again")}</button>}
        {!known.fixed && known.view !== "library" && <button class="plain" data-do="report" onClick={() => store.show("library")}>{t("create report")}</button>}
      </p>
      <ul class="worst">
        {bad.slice(0, 5).map((row) => {
          const s = worstState(row);
          const p = worstPart(row, s);
          const grade = row.grades[s]?.[p] === 2 ? "fail" : "warn";
          const open = known.selected?.inStrip === true && known.selected.row === row.id;
          return (
            <li key={row.id}>
              <button class={grade} {...disclosed(open)} onClick={() => store.look(open ? null : { row: row.id, state: s, part: p, inStrip: true })}>
                <b>{live && live.lines.length > 1 && `${row.line}: `}{row.name}</b>
                <span>{row.points?.[s]?.[p] || live?.states[s]?.said}{row.parts[p] ? `, ${row.parts[p]}` : ""}</span>
                <span>{atLeast(row, s, p)}{formatNumber(row.values[s]?.[p])} {row.unit} <i>{marginText(row.margins[s]?.[p])}</i></span>
              </button>
            </li>
          );
        })}
      </ul>
    </section>
  );
}

/** What is drawn in three dimensions is loaded when it is first looked at. */
function Later<P extends object>({ load, ...props }: { load: () => Promise<{ default: ComponentType<P> }> } & P) {
  const [Of, set] = useState<ComponentType<P> | null>(null);
  useEffect(() => void load().then((m) => set(() => m.default)), []);
  return Of ? <Of {...(props as unknown as P)} /> : <p class="note">…</p>;
}

/** A line that is straight from above is not drawn so, unless a handle moves something sideways. */
const topViewSaysSomething = (known: AppState, line: Line): boolean => {
  const across = [line.installed, ...line.states].flatMap((laid) => [...laid.joints, ...laid.ends]).map((p) => p[1]);
  return Math.max(...across) - Math.min(...across) > 0.5 || known.handles.some((h) => h.line === line.name && h.ways.includes("y"));
};

function Views({ known, shown }: { known: AppState; shown: ShownLine }) {
  const [deep, go] = useState(false);
  return (
    <Card id="views" title={t("Drawing")} note={<>{shown.where}{!deep && ` · ${t("light: the other states; dashed: as installed")}`}</>} head={
      <div class="chips" role="group" aria-label={t("Drawing")}>
        {!known.fixed && <KeepVariantButton known={known} />}
        <button aria-pressed={!deep} onClick={() => go(false)}>{t("side and top")}</button>
        <button aria-pressed={deep} onClick={() => go(true)}>3-D</button>
      </div>
    }>
      {deep ? (<Later load={() => import("./LineScene")} known={known} shown={shown} />) : (
        <>
          <Drawing known={known} shown={shown} view="side" />
          {topViewSaysSomething(known, shown.line) && <Drawing known={known} shown={shown} view="top" />}
        </>
      )}
    </Card>
  );
}
