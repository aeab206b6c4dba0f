// Where the line is shown: in one of its states, or where the sliders have it.

import { useMemo } from "preact/hooks";
import { Card, DataTable } from "./Card";
import { formatFixed, formatNumber, formatSigned } from "./format";
import { PastePointsForm } from "./NewFileForm";
import { Plot, type Series } from "./Plot";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { ShownLine } from "./Drawing";
import type { Curve, Ghost } from "./types";

export function StatePicker({ known, shown }: { known: AppState; shown: ShownLine }) {
  const { live, index, free } = shown;
  const pose = known.pose;
  const reach = pose?.travel_reach ?? [0, 0];
  const turns = pose?.torque_reach ?? [0, 0];
  const moves = reach[1] > reach[0];
  const winds = turns[1] > turns[0];
  // A page by itself goes from place to place, and says where it is.
  const travel = (known.fixed ? undefined : known.asked.travel_mm) ?? pose?.travel ?? 0;
  const torque = (winds ? known.asked.torque_Nm : undefined) ?? pose?.torque ?? 0;
  const braked = pose?.way === "brake";
  const ways = { drive: t("drive"), coast: t("overrun"), reverse: t("reverse"), brake: t("braking") };
  const slide = (travel_mm: number, torque_Nm: number, brakes = braked): void => store.pose({ line: index, travel_mm, torque_Nm, ...(brakes ? { way: "brake" } : {}) });
  return (
    <Card id="poser" title={t("State")} head={<>{free && known.asked.state === undefined && <span class="note">{t("at the sliders")}</span>}{pose?.stuck && <span class="note fail">{pose.stuck}</span>}</>}>
      {live.lines.length > 1 && (
        <div class="chips" role="group" aria-label={t("Line")}>
          {live.lines.map((l, k) => (<button key={l.name} aria-pressed={k === index} onClick={() => store.pose({ line: k })}>{l.name}</button>))}
        </div>
      )}
      <div class="chips" role="group" aria-label={t("State")}>
        {live.states.map((s, k) => (
          <button key={s.name} class={gradeOf(k, shown)} aria-pressed={k === shown.state && (!free || known.asked.state !== undefined)} onClick={() => store.pose({ line: index, state: k })}>{s.said}</button>
        ))}
      </div>
      {moves && (
        <div class="sliders">
          <Slider
            name={t("Travel")} low={reach[0]} high={reach[1]} step={known.fixed ? (reach[1] - reach[0]) / 40 : 0.5} value={travel} said={`${formatSigned(travel, 1)} mm`}
            ends={[t("rebound"), t("bump")]}
            set={(v) => slide(v, torque)}
          />
          {winds && (
            <Slider
              name={t("Torque, winding the axle up")} low={turns[0]} high={braked ? 0 : turns[1]} step={10} value={torque}
              said={[`${formatNumber(torque)} N·m`, (braked || torque) && pose && ways[pose.way], pose?.at && `${formatSigned(pose.at.pitch ?? 0, 2)}°`].filter(Boolean).join(", ")}
              ends={braked ? [t("overrun"), ""] : [t("overrun, reverse"), t("drive")]}
              set={(v) => slide(travel, v)}
            />
          )}
          {winds && pose?.brakes && <label class="tick"><input type="checkbox" data-field="brakes" checked={braked} onChange={() => slide(travel, braked ? torque : Math.min(torque, 0), !braked)} /> {t("brakes hold the axle, as far as its tyres do")}</label>}
        </div>
      )}
      {!moves && pose && <p class="note">{t("The file gives no suspension: there is no travel to show.")}</p>}
      <div class="curves">
        {pose?.over_travel && <Curves curve={pose.over_travel} over={t("over the travel [mm]")} at={travel} known={known} />}
        {pose?.over_torque && <Curves curve={pose.over_torque} over={t("over the torque [N·m]")} at={torque} known={known} />}
      </div>
    </Card>
  );
}

function gradeOf(state: number, shown: ShownLine): string {
  let found = 0;
  for (const row of store.rows()) {
    if (!row.values || row.line !== shown.line.name) continue;
    for (const g of row.grades[state] ?? []) found = Math.max(found, g ?? 0);
  }
  return ["pass", "warn", "fail"][found] ?? "";
}

interface Slides { name: string; low: number; high: number; step: number; value: number; said: string; ends: [string, string]; set: (value: number) => void; done?: () => void }

export function Slider(of: Slides) {
  return (
    <label class="slider">
      <span class="name">{of.name}</span>
      <output>{of.said}</output>
      <input type="range" min={of.low} max={of.high} step={of.step} value={of.value} aria-valuetext={of.said} onInput={(e) => of.set(Number(e.currentTarget.value))} onChange={() => of.done?.()} />
      <span class="end">{of.ends[0]}</span>
      <span class="end">{of.ends[1]}</span>
    </label>
  );
}

function Curves({ curve, over, at, known }: { curve: Curve; over: string; at: number; known: AppState }) {
  const [angles, rooms] = useMemo<[Series[], Series[]]>(
    () => [
      curve.angles.map((values, k) => ({ name: t("joint {n}", { n: k + 1 }), values, colour: k % 6 })),
      [...(curve.clearance ? [{ name: t("clearance"), values: curve.clearance, colour: 1 }] : []), { name: t("spline travel"), values: curve.plunge, colour: 0, dash: true }],
    ],
    [curve, known.lang],
  );
  return (
    <>
      <Plot x={curve.x} series={angles} degrees unit={`${t("joint angles [deg]")} ${over}`} at={at} height={150} theme={known.theme} label={`${t("joint angles [deg]")} ${over}`} />
      <Plot x={curve.x} series={rooms} unit={`[mm] ${over}`} at={at} height={150} theme={known.theme} label={`${t("clearance")}, ${t("spline travel")} ${over}`} />
    </>
  );
}

/** The angles of the line as it is shown. */
export function JointAngleTable({ known, shown }: { known: AppState; shown: ShownLine }) {
  const { line, state } = shown;
  const at = shown.free ? known.pose?.at : undefined;
  const of = (key: "angles" | "side_angles" | "top_angles" | "positions"): number[] => at?.[key] ?? line[key][state] ?? [];
  const ghost = known.behind === null || at ? undefined : (known.jobs.ghost as Job<Ghost> | undefined)?.answer?.lines.find((l) => l.name === line.name);
  const before = ghost?.angles[shown.live.states[state]?.name ?? ""];
  const plunge = at ? at.plunge : line.plunge[state];
  const rooms = (at?.clearance ?? line.clearance[state] ?? []).flat().filter((v) => v !== null);
  return (
    <Card id="angles" title={t("Joints")} note={shown.where}>
      <DataTable label={t("Joints")} head={[t("joint"), [t("angle")], ...(before ? [[known.variants[known.behind ?? 0]?.name] as [string]] : []), [t("side view")], [t("plan view")], [t("plane at")], t("size")]}>
        {of("angles").map((angle, k) => (
          <tr key={k}>
            <th scope="row">{k + 1}</th>
            <td class="n strong">{formatFixed(angle, 3)}°</td>
            {before && <td class="n before">{formatFixed(before[k], 3)}°</td>}
            <td class="n">{formatSigned(of("side_angles")[k] ?? 0, 3)}°</td>
            <td class="n">{formatSigned(of("top_angles")[k] ?? 0, 3)}°</td>
            <td class="n">{formatFixed(of("positions")[k], 1)}°</td>
            <td>{line.joints[k]}</td>
          </tr>
        ))}
      </DataTable>
      <p class="facts">
        <span>{t("spline travel")} <b>{plunge === null || plunge === undefined ? "–" : `${formatSigned(plunge, 1)} mm`}</b></span>
        {rooms.length > 0 && <span>{t("clearance")} <b>{formatFixed(Math.min(...(rooms as number[])), 1)} mm</b></span>}
        {known.pose?.line === shown.index && <span>{t("torque, as drawn")} <b>{formatNumber(known.pose.torque)} N·m</b></span>}
        {!shown.free && line.torque[state] !== null && <span>{t("torque of the state")} <b>{formatNumber(line.torque[state])} N·m</b></span>}
        {!shown.free && line.speed[state] !== null && <span>{t("speed of the state")} <b>{formatNumber(line.speed[state])} rpm</b></span>}
      </p>
      {!known.fixed && <PastePointsForm known={known} line={shown.index} />}
    </Card>
  );
}

