// What the server sends, as `cardan.web.answer` and `cardan.web.session` write it.

export type Point = [number, number, number];
export type Grade = "pass" | "warn" | "fail";
export type Verdict = Grade | "incomplete";
export type Maybe = number | null;

export interface Laid {
  joints: Point[];
  bearings: Point[];
  ends: [Point, Point];
}

/** A line in one place: a state, or where the sliders have it. */
export interface Place {
  laid: Laid;
  angles: number[];
  side_angles: number[];
  top_angles: number[];
  positions: number[];
  side: number[];
  top: number[];
  lengths: number[];
  plunge: Maybe;
  clearance: Maybe[][];
  phasors: [number, number][];
  equivalent: Maybe;
  pitch: Maybe;
}

export interface Line {
  name: string;
  installed: Laid;
  states: Laid[];
  tubes: Maybe[];
  tube_names: string[];
  joints: string[];
  phases: number[];
  phase_at: string[];
  tube_at: string[];
  tube_now: string[];
  joint_at: string[];
  joint_now: string[];
  angles: number[][];
  side_angles: number[][];
  top_angles: number[][];
  positions: number[][];
  side: number[][];
  top: number[][];
  lengths: number[][];
  plunge: Maybe[];
  travel: Maybe[];
  torque: Maybe[];
  speed: Maybe[];
  clearance: Maybe[][][];
  obstacles: number[];
  phasors: [number, number][][];
  equivalent: Maybe[];
  movable: Movable[];
  rings: { grade: Grade; radius: Maybe }[][];
}

export interface Obstacle {
  name: string;
  line: string;
  radius: number;
  share: number;
  start: Point;
  end: Point;
}

export type Kind = "joint" | "bearing" | "gearbox" | "pinion" | "obstacle";

export interface Handle {
  kind: Kind;
  number: number;
  line: string;
  ways: string;
}

export interface Limit {
  id: string;
  quantity: string;
  line: string;
  name: string;
  unit: string;
  sense: "<=" | ">=" | "band";
  normal: Maybe;
  maximum: Maybe;
  band: [number, number] | null;
  required: boolean;
  source: string;
}

export interface Row extends Limit {
  parts: string[];
  kinds: [string, number | string, string][];
  values: Maybe[][];
  margins: Maybe[][];
  /** 0 pass, 1 warn, 2 fail, by state and part; null where the limit does not ask. */
  grades: (number | null)[][];
  points?: string[][];
}

export interface State {
  name: string;
  said: string;
  kind: string;
}

export interface Curve {
  x: number[];
  angles: number[][];
  equivalent: Maybe[];
  plunge: Maybe[];
  clearance: Maybe[] | null;
}

export interface Turn {
  theta: number[];
  speed: number[][];
  rpm: Maybe;
  phases: number[];
  over_phase: number[][];
}

export interface Pose {
  line: number;
  state: number | null;
  travel: number;
  torque: number;
  travel_reach: [number, number];
  torque_reach: [number, number];
  at?: Place;
  over_travel?: Curve;
  over_torque?: Curve;
  turn?: Turn;
  stuck?: string;
}

export interface Problem {
  message: string;
  key: string;
  value: string;
  hint: string;
  line: number;
  column: number;
}

export type Edits = Record<string, number | string | number[]>;

export interface Live {
  title: string;
  profile: string;
  states: State[];
  worst: number;
  lines: Line[];
  obstacles: Obstacle[];
  handles?: Handle[];
  limits: Row[];
  pending: Limit[];
  grade: Grade | null;
  warnings: Problem[];
  pose?: Pose;
}

export interface Other {
  quantity: string;
  line: string;
  name: string;
  where: string;
  value: Maybe;
  bound: Maybe;
  sense: "<=" | ">=" | "band";
  unit: string;
  margin: Maybe;
  grade: Grade;
  source: string;
}

export interface Full {
  verdict: Verdict;
  counts: Record<Grade, number>;
  unanswered: string[];
  notes: string[];
  limits: Row[];
  others: Other[];
}

export interface Bar {
  said: string;
  value: Maybe;
  gain: number;
  edits: Edits;
}

export interface Help extends Other {
  bars: Bar[];
}

export interface Explained {
  name: string;
  symbol: string;
  unit: string;
  equation: string;
  where: [string, string][];
  use: string;
  source: string;
}

export interface Catalogue {
  joints: { name: string; series: string; peak_Nm: Maybe; reversing_Nm: Maybe; bearing_Nm: Maybe }[];
  tubes: { name: string; outer_mm: number; wall_mm: number }[];
}

export interface Diagram {
  title: string;
  rpm: number[];
  Hz_top: number;
  range: [number, number] | null;
  orders: { said: string; Hz: number[] }[];
  modes: { said: string; Hz: number }[];
  meets: { rpm: number; Hz: number; said: string }[];
  zones?: { rpm: number; open: boolean }[];
}

export type Force = "dynamic" | "peak";

export interface Speeds {
  line: string;
  state: number;
  said: string;
  rpm: number[];
  gears: { said: string; way: string; top: number }[];
  orders: number[];
  bearings: ({ said: string; orders: Maybe[][][]; limits: Record<Force, { warn: Maybe; fail: Maybe }[]>; grades: Record<Force, Maybe[][]> } & Record<Force, Maybe[][]>)[];
  diagrams: Diagram[];
}

export interface Torsion {
  state: string;
  diagrams: Diagram[];
  launches: {
    said: string;
    peak: number;
    target: number;
    locked: Maybe;
    slid: boolean;
    time: number[];
    torque: { said: string; values: number[] }[];
    bearing_time: number[];
    bearings: { said: string; values: number[] }[];
  }[];
}

export interface Guided {
  draft: string;
  verdict: Verdict;
  angles: number[];
  equivalent: Maybe;
  checks: Other[];
}

export interface Named {
  name: string;
  text: string;
}

export interface Ghost {
  lines: { name: string; states: Record<string, Laid>; angles: Record<string, number[]> }[];
}

export interface Compared {
  variants: { name: string; verdict: Verdict; counts: Record<Grade, number> }[];
  differences: { name: string; values: string[] }[];
  effects: { name: string; values: string[]; grades: (Grade | null)[] }[];
}

export interface Movable {
  id: string;
  said: string;
  unit: string;
  low: number;
  high: number;
  step: number;
  free: boolean;
  choice: boolean;
}

export interface Corrections {
  line: string;
  proposals: { verdict: Verdict; cost: number; margin: number; before: number; moves: string[]; counts: Record<Grade, number>; left: Other[]; edits: Edits }[];
}

export interface MapOf {
  x: { id: string; said: string; unit: string; values: number[] } | null;
  y: { id: string; said: string; unit: string; values: number[] } | null;
  sought: boolean;
  grades: number[][];
  margins: number[][];
  decides: number[][];
  names: string[];
}

export interface Yield {
  count: number;
  shares: Record<Grade, [number, number, number]>;
  yield?: [number, number, number];
  lost: { name: string; share: number }[];
  margins: number[];
  cases: number[][];
}

export interface LimitsOf {
  profile: string;
  named: string;
  plain: boolean;
  limits: { quantity: string; name: string; unit: string; sense: "<=" | ">=" | "band"; normal: Maybe; maximum: Maybe; band: [number, number] | null; states: string[]; required: boolean; source: string; signed: boolean }[];
}

export interface Status {
  file: number;
  name: string;
  draft: boolean;
  title: string;
  profile?: string;
  verdict: Verdict | null;
  counts?: Record<Grade, number>;
  worst?: { name: string; margin: number; where: string } | null;
  why: string;
}

interface Answered {
  id: number;
  text: string;
  problems?: Problem[];
  fault?: string;
}

export type Told =
  | {
      type: "welcome";
      version: string;
      lang: string;
      languages: string[];
      texts: Record<string, string>;
      quantities: Record<string, Explained>;
      catalogue: Catalogue;
      profiles: string[];
      files: string[];
    }
  | { type: "files"; files: string[] }
  | { type: "frozen"; file: number; revisions: (Named & { said: string })[] }
  | {
      type: "opened";
      file: number;
      name: string;
      saved: string;
      mark: string;
      draft: string | null;
      stale: boolean;
      variants: Named[];
      revisions: (Named & { said: string })[];
    }
  | ({ type: "live"; edits?: Edits } & Answered & Partial<Live>)
  | ({ type: "posed"; pose?: Pose } & Answered)
  | ({ type: "full" } & Answered & Partial<Full>)
  | ({ type: "helped"; helps?: Help[] } & Answered)
  | { type: "part"; id: number; job: string; part: object }
  | { type: "done"; id: number; job: string; fault?: string; problems?: Problem[] }
  | { type: "kept"; file: number }
  | { type: "saved"; file: number; mark: string; text: string }
  | { type: "disk"; file: number; text: string; mark: string; conflict: boolean }
  | { type: "refused"; what: string; file: number; why: string };

export interface Drag {
  kind: Kind;
  number: number;
  line: string;
  by_mm: Point;
}

export interface PoseAsked {
  line?: number;
  state?: number;
  travel_mm?: number;
  torque_Nm?: number;
}

export interface Question {
  text: string;
  drag?: Drag;
  edits?: Edits;
  held?: boolean;
  pose?: PoseAsked;
  want?: ("curves" | "turn")[];
}
