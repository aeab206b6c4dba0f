// What bearings carry over speed, gear by gear; where orders meet modes; the vehicle's torsion.

import { useEffect, useMemo, useState } from "preact/hooks";
import { Card } from "./Card";
import type { ShownLine } from "./Drawing";
import { CellMap } from "./CellMap";
import { formatFixed, formatNumber } from "./format";
import { GRADES, gradeText } from "./gradeLookup";
import { Plot, type Series } from "./Plot";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Diagram, Force, Speeds, Torsion } from "./types";

export function SpeedView({ known, shown }: { known: AppState; shown: ShownLine }) {
  const { index, state } = shown;
  useEffect(() => { if (!known.held) store.work("speeds", { line: index, state }); }, [known.history?.text, known.beside, known.held, index, state, known.lang]);
  const job = known.jobs.speeds as Job<Speeds> | undefined;
  const of = job?.answer;
  return (
    <div class="columns">
      <div class="left">
        {job?.why && <p class="notice fail">{job.why}</p>}
        {job?.running && of && <p class="note" role="status">{t("calculating …")}</p>}
        {of ? <Forces of={of} known={known} shown={shown} /> : !job?.why && <p class="card note">…</p>}
        <Launches known={known} />
      </div>
      <div class="right">
        {of?.diagrams.map((d) => <Campbell key={d.title} of={d} known={known} />)}
        <Vehicle known={known} />
      </div>
    </div>
  );
}

/** Edges between values that stand in the middle of cells. */
export const cellEdges = (values: number[]): number[] =>
  values.length < 2
    ? [(values[0] ?? 0) - 0.5, (values[0] ?? 0) + 0.5]
    : [...values, NaN].map((v, k) => {
        const [a, b] = [values[k - 1], values[k]];
        if (a === undefined) return v - ((values[1] ?? 0) - v) / 2;
        return b === undefined ? a + (a - (values[k - 2] ?? 0)) / 2 : (a + b) / 2;
      });

const shakenMost = (of: Speeds): number => {
  const most = of.bearings.map((b) => Math.max(0, ...b.dynamic.flat().map((v) => v ?? 0)));
  return Math.max(0, most.indexOf(Math.max(...most)));
};

function Forces({ of, known, shown }: { of: Speeds; known: AppState; shown: ShownLine }) {
  const [force, setForce] = useState<Force>("dynamic");
  const [bearing, setBearing] = useState(() => shakenMost(of));
  const [at, setAt] = useState<[number, number] | null>(null);
  const b = of.bearings[Math.min(bearing, of.bearings.length - 1)];
  const worst = useMemo<[number, number]>(() => {
    let found: [number, number] = [0, 0];
    let most = -1;
    b?.[force].forEach((row, r) => row.forEach((v, k) => { if ((v ?? -1) > most) [most, found] = [v ?? 0, [r, k]]; }));
    return found;
  }, [b, force]);
  if (!b) return <p class="card note">{t("The line has no centre bearing, or nothing says its torque over speed.")}</p>;
  const [g, k] = at && at[0] < of.gears.length && at[1] < of.rpm.length ? at : worst;
  const values = b[force];
  const edges = cellEdges(of.rpm);
  const most = Math.max(...values.flat().map((v) => v ?? 0), 1);
  const bounds = b.limits[force].flatMap((l) => (["warn", "fail"] as const).flatMap((grade) => (l[grade] === null ? [] : [{ value: l[grade], grade, said: gradeText(grade) }])));
  const value = values[g]?.[k];
  const grade = GRADES[b.grades[force][g]?.[k] ?? -1];
  const cut: Series[] = [
    { name: force === "peak" ? t("largest force") : t("all orders"), values: values[g] ?? [], colour: 0 },
    ...of.orders.map((n, o) => ({ name: t("order {order}", { order: n }), values: b.orders[o]?.[g] ?? [], colour: o + 1, dash: true })).filter((s) => s.values.some((v) => (v ?? 0) > 1e-6 * most)),
  ];
  return (
    <Card id="forces" kind="" title={t("Force on bearings over speed")} note={of.said}>
      <div class="chips" role="group" aria-label={t("State")}>
        {shown.live.states.map((s, i) => (<button key={s.name} aria-pressed={i === of.state} onClick={() => store.pose({ line: shown.index, state: i })}>{s.said}</button>))}
      </div>
      <div class="chips" role="group" aria-label={t("Force")}>
        {of.bearings.map((o, i) => <button key={o.said} aria-pressed={o === b} onClick={() => { setBearing(i); setAt(null); }}>{o.said}</button>)}
        <span class="apart" />
        <button aria-pressed={force === "dynamic"} onClick={() => { setForce("dynamic"); setAt(null); }}>{t("excitation")}</button>
        <button aria-pressed={force === "peak"} onClick={() => { setForce("peak"); setAt(null); }}>{t("largest force")}</button>
      </div>
      <div class="waterfall">
        <ul aria-hidden="true">{of.gears.map((o) => <li key={o.said}>{o.said}</li>)}</ul>
        <CellMap
          label={t("Force by gear and speed: choose with the arrow keys")}
          x={edges}
          y={of.gears.map((_, i) => i).concat(of.gears.length)}
          grades={b.grades[force]}
          strength={(r, c) => 0.12 + 0.88 * ((values[r]?.[c] ?? 0) / most)}
          at={[g, k]}
          choose={(r, c) => setAt([r, c])}
          said={`${of.gears[g]?.said}, ${formatNumber(of.rpm[k])} rpm: ${value === null || value === undefined ? "–" : `${formatNumber(value)} N`}${grade ? `, ${gradeText(grade)}` : ""}`}
          height={22 * of.gears.length}
          theme={known.theme}
        />
        <Plot
          x={of.rpm}
          range={[edges[0] ?? 0, edges[edges.length - 1] ?? 1]}
          series={cut}
          unit={`${t("force [N]")} ${t("over the shaft's speed [rpm]")}: ${of.gears[g]?.said}`}
          at={of.rpm[k] ?? null}
          height={240}
          theme={known.theme}
          label={t("Orders of the force over speed, {gear}", { gear: of.gears[g]?.said ?? "" })}
          beside={{ levels: bounds, top: 1.1 * Math.max(most, ...bounds.map((l) => l.value)) }}
        />
      </div>
    </Card>
  );
}

function Campbell({ of, known }: { of: Diagram; known: AppState }) {
  const series: Series[] = of.orders.map((o, k) => ({ name: o.said, values: o.Hz, colour: k }));
  return (
    <Card kind="campbell" title={of.title} note={t("where an order meets a frequency is resonance")}>
      <Plot
        x={of.rpm}
        series={series}
        unit={t("frequency [Hz] over the shaft's speed [rpm]")}
        height={230}
        theme={known.theme}
        label={`${of.title}: ${of.modes.map((m) => `${m.said} ${formatFixed(m.Hz, 1)} Hz`).join(", ")}`}
        beside={{ levels: of.modes.map((m) => ({ value: m.Hz, said: m.said })), spots: of.meets.map((m) => ({ x: m.rpm, y: m.Hz })), shade: of.range, top: of.Hz_top }}
      />
      {of.meets.length > 0 && (
        <details class="more">
          <summary>{t("Resonances")} ({of.meets.length})</summary>
          <ul>{of.meets.map((m) => <li key={m.said}>{m.said}: {formatNumber(m.rpm)} rpm, {formatFixed(m.Hz, 1)} Hz</li>)}</ul>
        </details>
      )}
    </Card>
  );
}

function Vehicle({ known }: { known: AppState }) {
  const job = known.jobs.torsion as Job<Torsion, { doing: string }> | undefined;
  const of = job?.answer;
  const [gear, setGear] = useState(0);
  const d = of?.diagrams[Math.min(gear, of.diagrams.length - 1)];
  return (
    <>
      <Card id="vehicle" title={t("The whole vehicle in torsion, and its launches")} head={<JobButton job={job} ask={() => store.work("torsion")} name="torsion" stale={job?.of !== store.about({})} />}>
        {of && (<div class="chips" role="group" aria-label={t("gear")}>{of.diagrams.map((o, k) => <button key={o.title} aria-pressed={o === d} onClick={() => setGear(k)}>{o.title}</button>)}</div>)}
      </Card>
      {d && <Campbell of={d} known={known} />}
    </>
  );
}

function Launches({ known }: { known: AppState }) {
  const of = (known.jobs.torsion as Job<Torsion> | undefined)?.answer;
  return (
    <>
      {of?.launches.map((l) => (
        <Card key={l.said} kind="launch" title={l.said} note={<>{t("largest {peak} N·m, engine torque by ratios T i {target} N·m", { peak: formatNumber(l.peak), target: formatNumber(l.target) })}{l.slid ? `, ${t("tyres slide")}` : ""}</>}>
          <Plot
            x={l.time}
            series={l.torque.map((s, k) => ({ name: s.said, values: s.values, colour: k, dash: k > 0 }))}
            unit={t("torque of the first shaft [N·m] over time [s]")}
            height={200}
            theme={known.theme}
            label={l.said}
            beside={{ levels: [{ value: l.target, said: "T i" }] }}
          />
          {l.bearings.length > 0 && (
            <Plot
              x={l.bearing_time}
              series={l.bearings.map((s, k) => ({ name: s.said, values: s.values, colour: k + 1 }))}
              unit={t("force on the bearings [N] over time [s]")}
              height={150}
              theme={known.theme}
              label={t("force on the bearings [N] over time [s]")}
            />
          )}
        </Card>
      ))}
    </>
  );
}

/** A button that asks for a job, says how far it is, and stops it. */
export function JobButton(of: { job: Job<unknown, unknown> | undefined; ask: () => void; name: string; stale: boolean; word?: string; disabled?: boolean }) {
  const part = of.job?.part as { doing?: string; done?: number; of?: number } | null | undefined;
  return (
    <span class="asking">
      {of.job?.running ? (
        <>
          <span role="status" class="note">{part?.doing ?? t("calculating …")}</span>
          <progress max={part?.of ?? 1} value={part?.of === undefined ? undefined : (part.done ?? 0)} aria-label={part?.doing ?? of.name} />
          <button onClick={() => store.stop(of.name)}>{t("stop")}</button>
        </>
      ) : (<button disabled={of.disabled || (!of.stale && of.job?.answer !== null)} onClick={of.ask}>{of.word ?? t("evaluate")}</button>)}
      {of.job?.why && <span class="note fail">{of.job.why}</span>}
      {of.stale && of.job?.answer !== null && of.job !== undefined && !of.job.running && <span class="note">{t("of the file as it was")}</span>}
    </span>
  );
}
