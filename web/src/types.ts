// What the page is told and what it says; the shapes of answers are made from their schema.

import type { Campaign, Catalogue, Edits, Explained, Full, Help, Kind, Line, Live, Named, Obstacle, Point, Pose, Problem, Row, Way } from "../made/types";

export type * from "../made/types";

interface Answered { id: number; text?: string; problems?: Problem[]; fault?: string }

/** What is known of the server before any file is opened. */
export interface Welcome { version: string; lang: string; languages: string[]; quantities: Record<string, Explained>; catalogue: Catalogue; profiles: string[]; files: string[]; missing: { use: string; extra: string }[]; bracket_example: string }

export type Revision = Named & { said: string };

export type ServerMessage =
  | ({ type: "welcome"; token: string; who: string; longest: number; texts: Record<string, string> } & Welcome)
  | { type: "files"; files: string[] }
  | { type: "frozen"; file: number; revisions: Revision[] }
  | { type: "opened"; file: number; name: string; saved: string; mark: string; draft: string | null; stale: boolean; base: string; elsewhere: boolean; left: number; variants: Named[]; revisions: Revision[] }
  | ({ type: "live"; edits?: Edits; campaign?: Campaign } & Answered & Partial<Live>)
  | ({ type: "moved"; lines?: (Pick<Line, "name"> & Partial<Line>)[]; obstacles?: Obstacle[]; pose?: Pose } & Answered)
  | ({ type: "graded"; limits?: Pick<Row, "id" | "values" | "margins" | "grades">[]; grade?: Live["grade"] } & Answered)
  | ({ type: "posed"; pose?: Pose } & Answered)
  | ({ type: "full" } & Answered & Partial<Full>)
  | ({ type: "helped"; helps?: Help[] } & Answered)
  | { type: "part"; id: number; job: string; part: object }
  | { type: "done"; id: number; job: string; fault?: string; problems?: Problem[] }
  | { type: "brought"; id: number; name: string; got: number; size: number }
  | { type: "kept"; file: number }
  | { type: "saved"; file: number; mark: string; text: string }
  | { type: "disk"; file: number; text: string; mark: string; conflict: boolean }
  | { type: "beside"; file: number }
  | { type: "refused"; what: string; file: number; why: string };

export interface ClientMessage { type: string; id?: number; job?: string; file?: number; held?: boolean; [more: string]: unknown }

export interface Drag { kind: Kind; number: number; line: string; by_mm: Point }

export interface PoseRequest { line?: number; state?: number; travel_mm?: number; torque_Nm?: number; way?: Way }

export interface EvaluationRequest { text: string; drag?: Drag; edits?: Edits; held?: boolean; pose?: PoseRequest; want?: ("curves" | "turn")[] }
