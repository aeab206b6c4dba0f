// The document and its past: what undo goes back to, what redo comes back to.

export interface EditHistory {
  readonly text: string;
  readonly past: readonly string[];
  readonly future: readonly string[];
  /** The text as it is on disk, and what marks it there. */
  readonly saved: string;
  readonly mark: string;
}

/** Steps that are kept. */
export const MAX_UNDO_STEPS = 300;

export const newHistory = (saved: string, mark: string, draft: string | null): EditHistory =>
  draft === null
    ? { text: saved, past: [], future: [], saved, mark }
    : { text: draft, past: [saved], future: [], saved, mark };

export const hasUnsavedEdits = (h: EditHistory): boolean => h.text !== h.saved;

/** A new text; `merge` lets it take the place of the last step, as letters typed do. */
export function withEdit(h: EditHistory, text: string, merge = false): EditHistory {
  if (text === h.text) return h;
  const past = merge && h.past.length > 0 ? h.past : [...h.past, h.text].slice(-MAX_UNDO_STEPS);
  return { ...h, text, past, future: [] };
}

export function undo(h: EditHistory): EditHistory {
  const before = h.past.at(-1);
  if (before === undefined) return h;
  return { ...h, text: before, past: h.past.slice(0, -1), future: [h.text, ...h.future] };
}

export function redo(h: EditHistory): EditHistory {
  const [next, ...future] = h.future;
  if (next === undefined) return h;
  return { ...h, text: next, past: [...h.past, h.text], future };
}

export const withSavedText = (h: EditHistory, saved: string, mark: string): EditHistory => ({ ...h, saved, mark });

/** What is on disk: taken over where it is another and nothing is unsaved, else only known of. */
export function mergeDiskText(h: EditHistory, text: string, mark: string): { now: EditHistory; conflict: boolean } {
  const known = { ...h, saved: text, mark };
  // As it was when it was edited, by its mark: touched, or gone and back.
  if (text === h.text || mark === h.mark) return { now: known, conflict: false };
  if (hasUnsavedEdits(h)) return { now: h, conflict: true };
  return { now: withEdit(known, text), conflict: false };
}
