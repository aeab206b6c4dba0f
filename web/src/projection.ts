// How millimetres of the vehicle become pixels of a view, and a hand's pixels millimetres.

import type { Laid, Line, Obstacle, Point } from "./types";

export type ViewDirection = "side" | "top";

/** The component that runs up the page in each view; in the plan view the vehicle's right. */
export const VERTICAL_COMPONENT: Record<ViewDirection, 1 | 2> = { side: 2, top: 1 };
export const VERTICAL_AXIS: Record<ViewDirection, "y" | "z"> = { side: "z", top: "y" };

const EXAGGERATIONS = [10, 5, 2, 1];
const LEFT = 26;
const RIGHT = 26;
const TOP = 46;
const BOTTOM = 74;

export interface DrawingScale {
  readonly width: number;
  readonly height: number;
  readonly scale: number;
  readonly times: number;
  readonly x: (along: number) => number;
  readonly y: (up: number) => number;
}

const all = (laid: Laid): Point[] => [...laid.joints, ...laid.ends];

/** A page in which everything of a line has room, exaggerated across as far as that goes. */
export function drawingScale(line: Line, obstacles: Obstacle[], view: ViewDirection, width: number, tallest: number): DrawingScale {
  const c = VERTICAL_COMPONENT[view];
  const points = [line.installed, ...line.states].flatMap(all);
  const along = points.map((p) => p[0]);
  const up = points.map((p) => p[c]);
  const start = Math.min(...along);
  const length = Math.max(...along) - start || 1;
  const thick = Math.max(60, ...line.tubes.map((d) => d ?? 0));
  const middle = (Math.min(...up) + Math.max(...up)) / 2;
  // From above a cross member runs off the page either way.
  const near = (view === "side" ? obstacles : [])
    .flatMap((o) => [o.start, o.end].map((p) => [p[c] - o.radius, p[c] + o.radius] as const))
    .filter(([a, b]) => Math.abs((a + b) / 2 - middle) < 0.15 * length);
  // What reaches far across is cut at the page's edge: the line is what it is about.
  const [least, most] = [Math.min(...up), Math.max(...up)];
  const beyond = 0.05 * length;
  const low = Math.max(Math.min(least, ...near.map(([a]) => a)), least - beyond) - 20;
  const high = Math.min(Math.max(most, ...near.map(([, b]) => b)), most + beyond) + 20;
  const scale = Math.max(0.01, (width - LEFT - RIGHT) / length);
  const room = tallest - TOP - BOTTOM - thick * scale; // a tube is as thick whatever offsets are exaggerated by
  const times = EXAGGERATIONS.find((k) => (high - low) * scale * k <= room) ?? 1;
  const height = Math.max((high - low) * scale * times + thick * scale, 60) + TOP + BOTTOM;
  const spare = (height - TOP - BOTTOM) / (scale * times) - (high - low);
  const floor = low - spare / 2;
  return { width, height, scale, times, x: (v) => LEFT + (v - start) * scale, y: (v) => height - BOTTOM - (v - floor) * scale * times };
}

/** Pixels that a hand moved, as millimetres along and up, in tenths. */
export function pixelsToMillimetres(p: DrawingScale, dx: number, dy: number): [number, number] {
  return [roundToTenth(dx / p.scale), roundToTenth(-dy / (p.scale * p.times))];
}

export const roundToTenth = (v: number): number => Math.round(v * 10) / 10 + 0;

/** What a handle is moved by in a view, along the axes it has. */
export function dragVector(ways: string, view: ViewDirection, right: number, up: number): Point {
  const by: Point = [ways.includes("x") ? right : 0, 0, 0];
  if (ways.includes(VERTICAL_AXIS[view])) by[VERTICAL_COMPONENT[view]] = up;
  return by;
}
