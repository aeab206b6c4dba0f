// Side and plan view: the line where it is shown, as installed and in its states; handles on it.

import { useMemo, useRef } from "preact/hooks";
import { formatFixed, formatSigned } from "./format";
import type { PartGrades } from "./gradeLookup";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import type { Drag, Ghost, Handle, Laid, Line, Live, Maybe, Obstacle, Point } from "./types";
import { useDragHandlers, useElementWidth } from "./hooks";
import { VERTICAL_COMPONENT, dragVector, VERTICAL_AXIS, pixelsToMillimetres, drawingScale, roundToTenth, type DrawingScale, type ViewDirection } from "./projection";

export interface ShownLine { live: Live; line: Line; index: number; state: number; laid: Laid; free: boolean; /** In words: a state, a point of it, or where sliders have it. */ where: string; marks: PartGrades }

const TALLEST: Record<ViewDirection, number> = { side: 330, top: 250 };

export function Drawing({ known, shown, view }: { known: AppState; shown: ShownLine; view: ViewDirection }) {
  const [box, width] = useElementWidth(900);
  const { live, line, state, marks } = shown;
  const obstacles = live.obstacles.filter((o) => o.line === line.name);
  const tallest = width < 560 ? 260 : TALLEST[view];
  const fresh = useMemo(() => drawingScale(line, obstacles, view, width, tallest), [live, width, view]);
  const still = useRef(fresh);
  // While a hand moves something the page keeps its scale: nothing else moves under it.
  if (!known.held || still.current.width !== fresh.width) still.current = fresh;
  const p = still.current;
  const c = VERTICAL_COMPONENT[view];
  const selected = known.selected;
  const chosen = selected && store.rows().find((r) => r.id === selected.row);
  const part = chosen?.values ? chosen.kinds[selected?.part ?? 0] : undefined;
  const near = part?.[0] === "clearance" && chosen?.line === line.name ? part[2] : undefined;
  const given = chosen?.quantity === "clearance_on_rubber" && (!shown.free || known.asked.state !== undefined) ? chosen.values?.[state]?.[selected?.part ?? 0] : undefined;
  const marked = (kind: string, n: number): boolean =>
    chosen?.line === line.name && part?.[0] === kind && part[1] === n;
  const points = (laid: Laid): Point[] => [laid.ends[0], ...laid.joints, laid.ends[1]];
  const path = (at: Point[]): string =>
    at.map((q, k) => `${k ? "L" : "M"}${p.x(q[0]).toFixed(1)} ${p.y(q[c]).toFixed(1)}`).join("");
  const bold = points(shown.laid);
  const others = useMemo(() => line.states.map((laid, s) => (s === state ? null : <path key={s} d={path(points(laid))} />)), [line.states, state, p, view]);
  const angles = view === "side" ? line.side_angles[state] : line.top_angles[state];
  const slopes = (view === "side" ? line.side : line.top)[state];
  const posed = shown.free ? known.pose?.at : undefined;
  const seen = {
    angles: posed ? (view === "side" ? posed.side_angles : posed.top_angles) : angles,
    slopes: posed ? (view === "side" ? posed.side : posed.top) : slopes,
    lengths: posed?.lengths ?? line.lengths[state],
  };
  const clearance = posed?.clearance ?? line.clearance[state];
  const title = view === "side" ? t("Side view, from the left") : t("Plan view");
  const before = known.behind === null ? undefined : (known.jobs.ghost as Job<Ghost> | undefined)?.answer?.lines.find((l) => l.name === line.name);
  const ghost = before?.states[live.states[state]?.name ?? ""];
  const mine = known.handles.filter((h) => h.line === line.name);

  return (
    <figure class="view" ref={box}>
      <figcaption>
        <b>{title}</b>
        <span>{p.times === 1 ? t("to scale") : t("lateral scale {times} : 1", { times: p.times })}</span>
      </figcaption>
      <svg class="drawing" width={p.width} height={p.height} viewBox={`0 0 ${p.width} ${p.height}`} role="group" aria-label={title}>
        <g class="states" aria-hidden="true">{others}</g>
        <path class="installed" d={path(points(line.installed))} aria-hidden="true" />
        {ghost && <path class="ghost" d={path(points(ghost))} aria-hidden="true" />}
        <g aria-hidden="true">{obstacles.map((o) => (<Bar key={o.name} of={o} p={p} c={c} lift={lift(o, shown, known)} chosen={o.name === near} />))}</g>
        <g aria-hidden="true">
          {bold.slice(0, -1).map((a, k) => {
            const b = bold[k + 1] as Point;
            const tube = k > 0 && k < bold.length - 2;
            const thick = Math.max(4, (tube ? (line.tubes[k - 1] ?? 50) : 50) * p.scale); // offsets are exaggerated, tubes are not
            const worst = tube ? marks[`shaft ${k}`] : null;
            const [x1, y1, x2, y2] = [p.x(a[0]), p.y(a[c]), p.x(b[0]), p.y(b[c])];
            const yoke = Math.min(yokeSize(p.width)[1] / Math.hypot(x2 - x1, y2 - y1), 0.45);
            const [front, rear] = [k > 0 ? yoke : 0, k < bold.length - 2 ? yoke : 0];
            return (
              <line
                key={k}
                class={`tube ${tube ? "" : "stub"} ${worst ?? ""} ${marked("shaft", k) || marked("clearance", k) ? "chosen" : ""}`}
                x1={x1 + front * (x2 - x1)} y1={y1 + front * (y2 - y1)} x2={x2 - rear * (x2 - x1)} y2={y2 - rear * (y2 - y1)}
                stroke-width={Math.min(thick, 60)}
              />
            );
          })}
          <path class="bold" d={path(bold)} />
        </g>
        <g aria-hidden="true">{shown.laid.joints.map((_, k) => <Yokes key={k} bold={bold} k={k} pins={shown.laid.pins[k] ?? []} p={p} c={c} last={shown.laid.joints.length - 1} grade={marks[`joint ${k + 1}`]} />)}</g>
        {view === "side" && <FrameLine bearings={shown.laid.bearings} bold={bold} p={p} />}
        <Dimensions p={p} bold={bold} c={c} slopes={seen.slopes} lengths={seen.lengths} obstacles={obstacles} />
        <g aria-hidden="true">
          {shown.laid.bearings.map((b, k) => (
            <Bearing key={k} x={p.x(b[0])} y={p.y(b[c])} n={k + 1} grade={marks[`centre bearing ${k + 1}`]} chosen={marked("centre bearing", k + 1)} />
          ))}
          {shown.laid.joints.map((q, k) => {
            const worst = marks[`joint ${k + 1}`];
            const [x, y] = [p.x(q[0]), p.y(q[c])];
            return (
              <g key={k} class={`joint ${worst ?? ""} ${marked("joint", k + 1) ? "chosen" : ""}`}>
                <circle cx={x} cy={y} r={9.5} />
                <text x={x} y={y + 4} text-anchor="middle">{k + 1}</text>
                <text class="angle" x={x} y={y + yokeSize(p.width)[0] + 16} text-anchor="middle">{bendText(seen.angles?.[k] ?? 0, view)}</text>
              </g>
            );
          })}
          {view === "side" && <Rooms live={live} line={line} clearance={clearance} p={p} c={c} shown={shown} known={known} given={near === undefined ? {} : { [near]: given }} />}
        </g>
        <Scale p={p} />
        <g class="handles">{mine.map((h) => (<Grip key={`${h.kind}${h.number}`} handle={h} view={view} p={p} shown={shown} known={known} />))}</g>
      </svg>
    </figure>
  );
}

/** A joint's angle in a view, and which way it bends there. */
const bendText = (angle: number, view: ViewDirection): string => `${formatFixed(Math.abs(angle), 2)}°${Math.abs(angle) < 0.005 ? "" : (angle < 0) === (view === "side") ? " ↑" : " ↓"}`;

/** An ear's reach from its member's axis and a yoke's length, px; smaller on a telephone. */
const yokeSize = (width: number): [number, number] => (width < 560 ? [11, 17] : [17, 26]);

/** The two yokes of a joint: a fork where its pin stands in the page, its ear's face where it points out of it. */
function Yokes(of: { bold: Point[]; k: number; pins: Point[]; p: DrawingScale; c: 1 | 2; last: number; grade: string | undefined }) {
  const { p, c, k } = of;
  const [EAR, YOKE] = yokeSize(p.width);
  const [x, y] = [p.x(of.bold[k + 1]?.[0] ?? 0), p.y(of.bold[k + 1]?.[c] ?? 0)];
  return (
    <>
      {of.pins.map((pin, side) => {
        const to = of.bold[k + 2 * side] as Point;
        const turn = (Math.atan2(p.y(to[c]) - y, p.x(to[0]) - x) * 180) / Math.PI;
        const [seen, faced] = [Math.abs(pin[c]), Math.abs(pin[3 - c] ?? 0)];
        const [h, face] = [EAR * seen, 0.5 * EAR * faced];
        const flanged = (k === 0 && side === 0) || (k === of.last && side === 1);
        return (
          <g key={side} class={`yoke ${of.grade ?? ""}`} transform={`translate(${x} ${y}) rotate(${turn})`}>
            {faced > 0.05 && <path d={`M-5 ${-face}H${0.7 * YOKE}L${YOKE} ${-0.6 * face}V${0.6 * face}L${0.7 * YOKE} ${face}H-5Z`} />}
            {seen > 0.05 && <path d={`M-4 ${h}H${0.6 * YOKE}L${YOKE} ${0.5 * h}V${-0.5 * h}L${0.6 * YOKE} ${-h}H-4V${-0.68 * h}H${0.5 * YOKE}L${0.72 * YOKE} 0L${0.5 * YOKE} ${0.68 * h}H-4Z`} />}
            {seen > 0.05 && <path class="pin" d={`M0 ${h + 3}V${-h - 3}`} />}
            {flanged && <path d={`M${YOKE} ${-EAR}h5v${2 * EAR}h-5Z`} />}
          </g>
        );
      })}
    </>
  );
}

/** The frame that bearings hang on, as far as the line stays below it. */
function FrameLine({ bearings, bold, p }: { bearings: Point[]; bold: Point[]; p: DrawingScale }) {
  if (!bearings.length) return null;
  const y = Math.min(...bearings.map((b) => p.y(b[2]))) - 33;
  const clear = (q: Point): boolean => p.y(q[2]) - 20 > y;
  const [first, last] = [bearings[0] as Point, bearings[bearings.length - 1] as Point];
  const ahead = bold.filter((q) => q[0] < first[0] && !clear(q)).at(-1);
  const behind = bold.find((q) => q[0] > last[0] && !clear(q));
  return <path class="frame" aria-hidden="true" d={`M${ahead ? p.x(first[0]) - 24 : p.x(bold[0]?.[0] ?? 0)} ${y}H${behind ? p.x(last[0]) + 24 : p.x(bold.at(-1)?.[0] ?? 0)}`} />;
}

/** How far an obstacle has gone with the axle, mm. */
function lift(o: Obstacle, shown: ShownLine, known: AppState): number {
  const travel = shown.free ? known.pose?.travel : shown.line.travel[shown.state];
  return o.share * (travel ?? 0);
}

function Bar({ of, p, c, lift: up, chosen }: { of: Obstacle; p: DrawingScale; c: 1 | 2; lift: number; chosen: boolean }) {
  const rise = c === 2 ? up : 0;
  const [x1, x2] = [p.x(of.start[0]), p.x(of.end[0])];
  const [y1, y2] = [p.y(of.start[c] + rise), p.y(of.end[c] + rise)];
  const r = Math.max(of.radius * p.scale, 1.5);
  const flat = Math.hypot(x2 - x1, y2 - y1) < 1;
  return (<g class={`obstacle ${chosen ? "chosen" : ""}`}>{flat ? (<circle cx={x1} cy={y1} r={r} />) : (<line x1={x1} y1={y1} x2={x2} y2={y2} stroke-width={2 * r} />)}</g>);
}

function Rooms(of: { live: Live; line: Line; clearance: Maybe[][] | undefined; p: DrawingScale; c: 1 | 2; shown: ShownLine; known: AppState; given: Record<string, Maybe | undefined> }) {
  const { live, line, p, c } = of;
  return (
    <>
      {line.obstacles.map((number, k) => {
        const o = live.obstacles[number];
        if (!o) return null;
        const free = (of.clearance ?? []).map((room) => room[k]).filter((v) => v !== null && v !== undefined);
        const [first, last] = [Math.min(o.start[0], o.end[0]) - o.radius, Math.max(o.start[0], o.end[0]) + o.radius].map(p.x) as [number, number];
        const left = of.given[o.name];
        // Beside it, or where that is on the line itself, below.
        const [behind, narrow] = [last < p.width - (left === undefined ? 180 : 260), p.width < 560];
        const x = narrow ? p.x(of.shown.laid.joints.at(-1)?.[0] ?? 0) - 26 : behind ? last + 8 : first - 8;
        const up = p.y((o.start[c] + o.end[c]) / 2 + lift(o, of.shown, of.known)) + (narrow ? 24 : 0);
        const y = Math.min(Math.max(up, 60), p.height - 62);
        const room = free.length ? `${formatFixed(Math.min(...free), 1)} mm` : "";
        return (
          <g key={number} class="room" text-anchor={behind && !narrow ? "start" : "end"}>
            <text x={x} y={y - 3}>{o.name.length > 28 ? `${o.name.slice(0, 27)}…` : o.name}{narrow && ` ${room}`}</text>
            <text x={x} y={y + 11}>{!narrow && room}</text>
            {typeof left === "number" && <text class="onrubber" x={x} y={y + (narrow ? 11 : 25)}>{t("{room} mm free on rubber", { room: formatFixed(left, 1) })}</text>}
          </g>
        );
      })}
    </>
  );
}

function Bearing(of: { x: number; y: number; n: number; grade: string | undefined; chosen: boolean }) {
  const { x, y } = of;
  return (
    <g class={`bearing ${of.grade ?? ""} ${of.chosen ? "chosen" : ""}`}>
      <rect x={x - 6} y={y - 14} width={12} height={28} rx={2} />
      <path d={`M${x} ${y - 14}V${y - 32}M${x - 12} ${y - 32}H${x + 12}`} />
    </g>
  );
}

/** Shares of a member's length at which its slope and length may stand, best first. */
const DIMENSION_PLACES = [0.5, 0.36, 0.64, 0.24, 0.76, 0.14, 0.86];
const DIMENSION_HALF_WIDTH = 34;

function Dimensions(of: { p: DrawingScale; bold: Point[]; c: 1 | 2; slopes: number[] | undefined; lengths: number[] | undefined; obstacles: Obstacle[] }) {
  const { p, bold, c } = of;
  const covers = (o: Obstacle, x: number): boolean => {
    const [first, last] = [Math.min(o.start[0], o.end[0]) - o.radius, Math.max(o.start[0], o.end[0]) + o.radius].map(p.x) as [number, number];
    const foot = p.y(Math.min(o.start[c], o.end[c])) + o.radius * p.scale;
    return foot > p.height - 45 && x + DIMENSION_HALF_WIDTH > first && x - DIMENSION_HALF_WIDTH < last;
  };
  return (
    <g class="dimensions" aria-hidden="true">
      {bold.slice(0, -1).map((a, k) => {
        const b = bold[k + 1] as Point;
        const half = Math.abs(p.x(b[0]) - p.x(a[0])) / 2 - DIMENSION_HALF_WIDTH; // what a label may move without reaching its neighbours'
        const share = DIMENSION_PLACES.find((s) => Math.abs(s - 0.5) * (p.x(b[0]) - p.x(a[0])) <= half && !of.obstacles.some((o) => covers(o, p.x(a[0] + s * (b[0] - a[0]))))) ?? 0.5;
        const [x, y] = [p.x(a[0] + share * (b[0] - a[0])), p.y(a[c] + share * (b[c] - a[c]))];
        const length = k > 0 && k < bold.length - 2 ? of.lengths?.[k - 1] : undefined;
        const room = Math.abs(p.x(b[0]) - p.x(a[0]));
        return (
          <g key={k}>
            <line x1={x} y1={y + 3} x2={x} y2={p.height - 44} />
            <text x={x} y={p.height - 31} text-anchor="middle">{formatSigned(of.slopes?.[k] ?? 0, 2)}°</text>
            {length !== undefined && room > 70 && (<text x={x} y={p.height - 17} text-anchor="middle">{formatFixed(length, 0)} mm</text>)}
          </g>
        );
      })}
    </g>
  );
}

function Scale({ p }: { p: DrawingScale }) {
  const size = [1000, 500, 200, 100, 50].find((m) => m * p.scale < 0.3 * p.width) ?? 50;
  const [x1, x2, y] = [26, 26 + size * p.scale, p.height - 4];
  return (
    <g class="scale" aria-hidden="true">
      <path d={`M${x1} ${y - 4}V${y}H${x2}V${y - 4}`} />
      <text x={x2 + 6} y={y}>{size} mm</text>
    </g>
  );
}

/** Where a handle is drawn in the line as it is shown. */
function spot(h: Handle, shown: ShownLine, known: AppState, view: ViewDirection): Point | undefined {
  const { laid, live } = shown;
  if (h.kind === "joint") return laid.joints[h.number - 1];
  // Every shaft but the last has a bearing.
  if (h.kind === "bearing") return laid.bearings[h.number - 1];
  if (h.kind === "gearbox") return laid.ends[0];
  if (h.kind === "pinion") return laid.ends[1];
  const o = live.obstacles[h.number - 1];
  if (!o) return undefined;
  const middle = o.start.map((v, k) => (v + (o.end[k] ?? v)) / 2) as Point;
  if (view === "side") middle[2] += lift(o, shown, known);
  return middle;
}

function Grip(of: { handle: Handle; view: ViewDirection; p: DrawingScale; shown: ShownLine; known: AppState }) {
  const { handle: h, view, p, shown, known } = of;
  const name = `${view}/${h.line}/${h.kind}/${h.number}`;
  const drag = (by: Point): { drag: Drag } => ({ drag: { kind: h.kind, number: h.number, line: h.line, by_mm: by } });
  const hand = useDragHandlers({
    moved: (dx, dy) => {
      const [right, up] = pixelsToMillimetres(p, dx, dy);
      store.hold(name, drag(dragVector(h.ways, view, right, up)));
    },
    stepped: (right, up) => store.hold(name, drag(dragVector(h.ways, view, roundToTenth(right), roundToTenth(up)))),
    release: () => store.release(),
    cancel: () => store.cancel(),
  });
  const at = spot(h, shown, known, view);
  if (!at || !h.ways.includes(VERTICAL_AXIS[view])) return null;
  const c = VERTICAL_COMPONENT[view];
  const label = t("{part}, {way}: drag, or use the arrow keys", { part: said(h, shown), way: view === "side" ? t("height") : t("to the side") });
  const y = p.y(at[c]) - (h.kind === "bearing" ? 23 : 0);
  return (
    <g
      class={`grip on-${h.kind} ${known.held === name ? "held" : ""}`}
      tabindex={0} role="slider" aria-label={label} aria-orientation="vertical"
      aria-valuenow={Math.round(at[c] * 10) / 10}
      aria-valuetext={`${formatFixed(at[c], 1)} mm`}
      data-handle={name}
      {...hand}
    >
      <title>{label}</title>
      <circle class="reach" cx={p.x(at[0])} cy={y} r={18} />
      <circle class="dot" cx={p.x(at[0])} cy={y} r={h.kind === "bearing" ? 6.5 : h.kind === "joint" ? 12.5 : 6} />
    </g>
  );
}

function said(h: Handle, shown: ShownLine): string {
  const n = h.number;
  return { joint: t("joint {n}", { n }), bearing: t("centre bearing {n}", { n }), gearbox: t("gearbox slope"), pinion: t("pinion slope"), obstacle: shown.live.obstacles[n - 1]?.name ?? "" }[h.kind];
}
