// What of a drawing does not pass: looked up in the limits, nothing decided here.

import type { Grade, Row, Verdict } from "./types";

export const GRADES: Grade[] = ["pass", "warn", "fail"];
export const VERDICTS: Verdict[] = ["pass", "warn", "incomplete", "fail"];

/** The worst grade of a part of a line in a state; null where no limit asks about it. */
export function grade(rows: { line: string; kinds?: Row["kinds"]; grades?: Row["grades"] }[], line: string, state: number, kind: string, number: number): Grade | null {
  let found = -1;
  for (const row of rows) {
    if (row.line !== line || !row.kinds || !row.grades) continue;
    row.kinds.forEach(([k, n], p) => { if (k === kind && n === number) found = Math.max(found, row.grades?.[state]?.[p] ?? -1); });
  }
  return GRADES[found] ?? null;
}
