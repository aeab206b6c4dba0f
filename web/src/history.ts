// The document and its past: what undo goes back to, what redo comes back to.

export interface History {
  readonly text: string;
  readonly past: readonly string[];
  readonly future: readonly string[];
  /** The text as it is on disk, and what marks it there. */
  readonly saved: string;
  readonly mark: string;
}

/** Steps that are kept. */
export const MOST = 300;

export const opened = (saved: string, mark: string, draft: string | null): History =>
  draft === null
    ? { text: saved, past: [], future: [], saved, mark }
    : { text: draft, past: [saved], future: [], saved, mark };

export const unsaved = (h: History): boolean => h.text !== h.saved;

/** A new text; `merge` lets it take the place of the last step, as letters typed do. */
export function edited(h: History, text: string, merge = false): History {
  if (text === h.text) return h;
  const past = merge && h.past.length > 0 ? h.past : [...h.past, h.text].slice(-MOST);
  return { ...h, text, past, future: [] };
}

export function undone(h: History): History {
  const before = h.past.at(-1);
  if (before === undefined) return h;
  return { ...h, text: before, past: h.past.slice(0, -1), future: [h.text, ...h.future] };
}

export function redone(h: History): History {
  const [next, ...future] = h.future;
  if (next === undefined) return h;
  return { ...h, text: next, past: [...h.past, h.text], future };
}

export const written = (h: History, saved: string, mark: string): History => ({ ...h, saved, mark });

/** What is on disk: taken over where it is another and nothing is unsaved, else only known of. */
export function onDisk(h: History, text: string, mark: string): { now: History; conflict: boolean } {
  const known = { ...h, saved: text, mark };
  // As it was when it was edited, by its mark: touched, or gone and back.
  if (text === h.text || mark === h.mark) return { now: known, conflict: false };
  if (unsaved(h)) return { now: h, conflict: true };
  return { now: edited(known, text), conflict: false };
}
