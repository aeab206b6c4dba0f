// What to change: corrections with holds, a map of two moves, what remains where moves scatter.

import { useEffect, useState } from "preact/hooks";
import { Card, Select } from "./Card";
import type { ShownLine } from "./Drawing";
import { CellMap } from "./CellMap";
import { formatFixed, formatNumber, formatPercent, withDecimalSign } from "./format";
import { VERDICTS, verdictText } from "./gradeLookup";
import { JobButton, cellEdges } from "./SpeedView";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Corrections, MapOf, Movable, Yield } from "./types";
import { useRetainedState } from "./hooks";

type Both = { known: AppState; shown: ShownLine };

export function CorrectionsView(both: Both) {
  return (
    <div class="columns">
      <div class="left"><Fix {...both} /><Scatter {...both} /></div>
      <div class="right"><Map {...both} /></div>
    </div>
  );
}

function Fix({ known, shown }: Both) {
  const [hold, set] = useRetainedState<string[]>(`hold/${known.file}/${shown.index}`, []);
  const job = known.jobs.fix as Job<Corrections, Pick<Corrections, "proposals">> | undefined;
  const args = { line: shown.index, hold };
  const sofar = job?.running || job?.why ? job.part?.proposals : undefined; // stopped, it keeps that
  const found = sofar ?? job?.answer?.proposals;
  const stale = job?.of !== store.about(args); // what moves the file as it was would be on top of what moved it since
  return (
    <Card id="fix" title={t("Corrections")} head={<JobButton job={job} name="fix" word={t("optimise")} stale={stale} ask={() => store.work("fix", args)} />}>
      <fieldset>
        <legend class="note">{t("what may move")}</legend>
        {shown.line.movable.filter((m) => m.free).map((m) => (
          <label key={m.id} class="tick">
            <input type="checkbox" checked={!hold.includes(m.id)} onChange={() => set(hold.includes(m.id) ? hold.filter((h) => h !== m.id) : [...hold, m.id])} />
            {m.said} <small>{reach(m)}{m.step > 0 && ` · ${t("in steps of {step}", { step: formatNumber(m.step) })}`}</small>
          </label>
        ))}
      </fieldset>
      {sofar && <p class="note" role="status">{t("the best so far")}</p>}
      {found?.length === 0 && <p class="note">{t("No move within the ranges improves the line.")}</p>}
      {found && found.length > 0 && !sofar && <><Front of={found} stale={stale} /><p class="note">{job?.answer?.scatter}</p></>}
      <ol class="proposals">
        {found?.map((p, k) => (
          <li key={k} class={p.verdict}>
            <p><b class={p.verdict}>{verdictText(p.verdict)}</b> {p.moves.join("; ")}</p>
            <p class="note">{p.margins}{p.survives.map((s) => <small key={s}>{s}</small>)}{p.left.map((s) => <small key={s}>{s}</small>)}</p>
            <button disabled={stale || Object.keys(p.edits).length === 0} onClick={() => { store.pin(); store.apply(p.edits); }}>{t("apply, and keep the present as variant")}</button>
          </li>
        ))}
      </ol>
      {found && !sofar && <pre tabindex={0}>{job?.answer?.command}</pre>}
    </Card>
  );
}

/** What asks the same again, of the file as it was saved. */
const Again = ({ of = [] }: { of?: string[] | undefined }) => <>{of.map((one) => <pre key={one} tabindex={0}>{one}</pre>)}</>;

const unit = (of: string): string => ({ deg: "°", percent: "%" })[of] ?? of;
const reach = (m: Movable): string => `${formatNumber(m.low)} … ${formatNumber(m.high)} ${unit(m.unit)}`;

/** Cost against margin: each proposal a point to click on. */
function Front({ of, stale }: { of: Corrections["proposals"]; stale: boolean }) {
  const [costs, margins] = [of.map((p) => p.cost), of.map((p) => p.margin)];
  const most = Math.max(...costs, 1e-9);
  const [low, high] = [Math.min(...margins), Math.max(...margins)];
  return (
    <svg class="front" viewBox="0 0 320 120" role="group" aria-label={t("margin against cost")}>
      <path class="axes" d="M30 10V100H310" />
      <text x="310" y="116" text-anchor="end">{t("cost")}</text><text x="4" y="10">{t("margin")}</text>
      {of.map((p, k) => {
        const [x, y] = [36 + (260 * p.cost) / most, 92 - (76 * (p.margin - low)) / (high - low || 1)];
        const go = (): void => { if (!stale) [store.pin(), store.apply(p.edits)]; };
        return (
          <g key={k} role="button" tabindex={0} aria-disabled={stale} class={p.verdict} aria-label={`${k + 1}: ${p.moves.join("; ")}`} onClick={go} onKeyDown={(e) => { if (e.key === "Enter" || e.key === " ") { e.preventDefault(); go(); } }}>
            <title>{p.moves.join("; ")}</title><circle cx={x} cy={y} r={7} /><text x={x + 11} y={y + 4}>{k + 1}</text>
          </g>
        );
      })}
    </svg>
  );
}

function Choice({ of, value, set, label }: { of: Movable[]; value: string; set: (id: string) => void; label: string }) {
  return (
    <Select label={label} value={value} choose={set} of={of.map((m) => [m.id, m.said] as const)} />
  );
}

function Map({ known, shown }: Both) {
  const every = shown.line.movable;
  const [x, setX] = useState(every[0]?.id ?? "");
  const [y, setY] = useState((every.find((m) => m.id === "shim 1") ?? every[1])?.id ?? "");
  const [sought, seek] = useState(false);
  const [at, setAt] = useState<[number, number] | null>(null);
  const args = { line: shown.index, x, y, sought };
  useEffect(() => { if (!known.held && !sought) store.work("map", args); }, [known.history?.text, known.beside, known.held, shown.index, x, y, sought, known.lang]);
  const job = known.jobs.map as Job<MapOf, { map?: MapOf }> | undefined;
  const of = (job?.running ? job.part?.map : undefined) ?? job?.answer;
  const moved = known.jobs.moved as Job<{ edits: Record<string, number> }> | undefined;
  useEffect(() => { if (moved?.answer && !moved.running) store.taken("moved", moved.answer.edits); }, [moved?.answer]);
  const n = of?.x?.values.length ?? 0;
  // Where nothing is moved, until somebody chooses.
  const still = (values: number[] = []): number => values.reduce((best, v, k) => (Math.abs(v) < Math.abs(values[best] ?? 0) ? k : best), 0);
  const [r, c] = at && at[0] < n && at[1] < n ? at : [still(of?.y?.values), still(of?.x?.values)];
  const cell = of?.x && of.y ? { x: of.x.values[c] ?? 0, y: of.y.values[r] ?? 0, verdict: VERDICTS[of.verdicts[r]?.[c] ?? 3] ?? "fail", margin: of.margins[r]?.[c], name: of.names[of.decides[r]?.[c] ?? -1] } : null;
  return (
    <Card id="map" title={t("Map of two moves")} head={<JobButton job={job} name="map" stale={job?.of !== store.about(args)} ask={() => store.work("map", args)} />}>
      <div class="fields">
        <label>{t("to the right")}<Choice of={every.filter((m) => m.id !== y)} value={x} set={setX} label={t("to the right")} /></label>
        <label>{t("up")}<Choice of={every.filter((m) => m.id !== x)} value={y} set={setY} label={t("up")} /></label>
        <label class="tick"><input type="checkbox" checked={sought} onChange={() => seek(!sought)} />{t("with bearing forces over all speeds: takes longer")}</label>
      </div>
      {of?.x && of.y && cell && (
        <>
          <CellMap
            label={t("Map of two moves: choose with the arrow keys")}
            x={cellEdges(of.x.values)}
            y={cellEdges(of.y.values)}
            up
            grades={of.verdicts}
            among={VERDICTS}
            strength={(row, column) => 0.25 + 0.7 * Math.min(1, Math.abs(of.margins[row]?.[column] ?? 1))}
            at={[r, c]}
            choose={(row, column) => setAt([row, column])}
            said={`${of.x.said} ${formatNumber(cell.x)} ${unit(of.x.unit)}, ${of.y.said} ${formatNumber(cell.y)} ${unit(of.y.unit)}: ${verdictText(cell.verdict)}, ${cell.name ?? ""}${cell.margin === null || cell.margin === undefined ? "" : ` ${formatPercent(cell.margin)} %`}`}
            height={330}
            theme={known.theme}
          />
          <p class="note">↑ {of.y.said} [{unit(of.y.unit)}]: {formatNumber(of.y.values[0])} … {formatNumber(of.y.values.at(-1))}</p>
          <p class="ends note"><span>{formatNumber(of.x.values[0])}</span><span>{of.x.said} [{unit(of.x.unit)}] →</span><span>{formatNumber(of.x.values.at(-1))}</span></p>
          <button data-do="move" onClick={() => store.work("moved", { line: shown.index, moves: [{ id: of.x?.id ?? "", amount: cell.x }, { id: of.y?.id ?? "", amount: cell.y }] })}>{t("apply this move")}</button>
          {!of.sought && <p class="note">{t("Without bearing forces sought over all speeds.")}</p>}
          <Again of={of.commands} />
        </>
      )}
      {of && !of.x && <p class="note">{t("Fewer than two moves are permitted: no map.")}</p>}
    </Card>
  );
}

/** One standard deviation of what a workshop sets, where nobody says: assumed. */
const SIGMA: Record<string, number> = { mm: 1, deg: 0.17, percent: 5 };

function Scatter({ known, shown }: Both) {
  const every = shown.line.movable;
  const [given, give] = useRetainedState<Record<string, string>>(`sigma/${known.file}/${shown.index}`, {});
  const sigma = (m: Movable): string => given[m.id] ?? (m.choice ? "1" : m.free ? withDecimalSign(String(SIGMA[m.unit] ?? 1)) : "0");
  const sigmas = every.map((m) => ({ id: m.id, amount: sigma(m).trim() })).filter((s) => !["", "0"].includes(s.amount));
  const args = { line: shown.index, sigmas, count: 4096 };
  const job = known.jobs.yield as Job<Yield, { yield?: Yield }> | undefined;
  const of = (job?.running ? job.part?.yield : undefined) ?? job?.answer;
  const cases = of?.cases ?? [];
  const most = Math.max(1, ...(cases[0] ?? []).map((_, k) => cases.reduce((sum, row) => sum + (row[k] ?? 0), 0)));
  return (
    <Card id="scatter" title={t("What remains under tolerances")} head={<JobButton job={job} name="yield" word={t("try {count}", { count: 4096 })} stale={job?.of !== store.about(args)} ask={() => store.work("yield", args)} disabled={sigmas.length === 0} />}>
      <div class="fields">
        {every.map((m) => <label key={m.id}>{m.said} ± [{unit(m.unit)}]<input inputMode="decimal" value={sigma(m)} onInput={(e) => give({ ...given, [m.id]: e.currentTarget.value })} /></label>)}
      </div>
      <p class="note">{t("One standard deviation each, about what the file says; assumed.")} {t("Without bearing forces sought over all speeds.")}</p>
      {of?.yield && (
        <>
          <p class="figure"><b>{formatFixed(100 * of.yield[0], 2)} %</b> {t("yield ({low} to {high} %, {count} variants)", { low: formatFixed(100 * of.yield[1], 2), high: formatFixed(100 * of.yield[2], 2), count: of.count })}</p>
          <p class="chips">{VERDICTS.map((v) => { const share = of.shares[v]?.[0] ?? 0; return share > 0 && <span key={v}><b class={v}>{formatFixed(100 * share, 2)} %</b> {verdictText(v)}</span>; })}</p>
          <svg class="bins" viewBox="0 0 240 62" role="img" aria-label={t("cases by their smallest margin")}>
            {cases.map((row, g) => row.map((v, k) => {
              const below = cases.slice(0, g).reduce((sum, r) => sum + (r[k] ?? 0), 0);
              return v > 0 && <rect key={`${g}/${k}`} class={VERDICTS[g] ?? ""} x={10 * k} y={50 - (48 * (below + v)) / most} width={9} height={(48 * v) / most} />;
            }))}
            <text x="0" y="61">−100 %</text><text x="120" y="61" text-anchor="middle">0</text><text x="240" y="61" text-anchor="end">+100 %</text>
          </svg>
          <Again of={of.commands} />
          <ul class="others">{of.lost.map((l) => <li key={l.name}><b>{formatFixed(100 * l.share, 2)} %</b> {l.name}</li>)}</ul>
        </>
      )}
    </Card>
  );
}
