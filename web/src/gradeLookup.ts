// What of a drawing does not pass: looked up in the limits, nothing decided here.

import { t } from "./i18n";
import type { Grade, Maybe, Row, Verdict } from "./types";

export const GRADES: Grade[] = ["pass", "warn", "fail"];
export const VERDICTS: Verdict[] = ["pass", "warn", "incomplete", "fail"];

/** A verdict as every other medium words it; the grade of a single check has its own words. */
export function verdictText(verdict: Verdict): string {
  return { pass: t("approved"), warn: t("approved with warnings"), incomplete: t("incomplete"), fail: t("not approved") }[verdict];
}

/** The grade of a criterion or of a check as every other medium words it. */
export const gradeText = (grade: Grade): string => ({ pass: t("met"), warn: t("beyond recommended"), fail: t("exceeded") })[grade];

export type PartGrades = Record<string, Grade | undefined>;

/** The worst grade of each part of a line in a state, as "joint 2"; of none where no limit asks. */
export function partGrades(rows: { line: string; kinds?: Row["kinds"]; grades?: Row["grades"] }[], line: string, state: number): PartGrades {
  const found: Record<string, Maybe> = {};
  for (const row of rows) {
    if (row.line !== line) continue;
    row.kinds?.forEach(([kind, n], p) => { found[`${kind} ${n}`] = Math.max(found[`${kind} ${n}`] ?? -1, row.grades?.[state]?.[p] ?? -1); });
  }
  return Object.fromEntries(Object.entries(found).map(([part, g]) => [part, GRADES[g ?? -1]]));
}
