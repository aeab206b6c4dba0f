import { describe, expect, it } from "vitest";
import { withEdit, MAX_UNDO_STEPS, mergeDiskText, newHistory, redo, undo, hasUnsavedEdits, withSavedText } from "../src/history";

const start = newHistory("a", "m", null);

describe("the document and its past", () => {
  it("goes back and comes back, step by step", () => {
    const two = withEdit(withEdit(start, "b"), "c");
    expect(undo(undo(two)).text).toBe("a");
    expect(redo(redo(undo(undo(two)))).text).toBe("c");
    expect(undo(undo(undo(two)))).toMatchObject({ text: "a", past: [] });
  });

  it("forgets what was undone once something new is done", () => {
    const again = withEdit(undo(withEdit(start, "b")), "c");
    expect(again.future).toEqual([]);
    expect(undo(again).text).toBe("a");
  });

  it("takes letters typed for one step", () => {
    const typed = withEdit(withEdit(withEdit(start, "ab"), "abc", true), "abcd", true);
    expect(undo(typed).text).toBe("a");
  });

  it("is the same where nothing changes", () => {
    expect(withEdit(start, "a")).toBe(start);
    expect(undo(start)).toBe(start);
    expect(redo(start)).toBe(start);
  });

  it("keeps no more steps than it should", () => {
    let h = start;
    for (let k = 0; k < MAX_UNDO_STEPS + 50; k++) h = withEdit(h, `${k}`);
    expect(h.past.length).toBe(MAX_UNDO_STEPS);
    expect(undo(h).text).toBe(`${MAX_UNDO_STEPS + 48}`);
  });

  it("knows what is saved", () => {
    const changed = withEdit(start, "b");
    expect(hasUnsavedEdits(start)).toBe(false);
    expect(hasUnsavedEdits(changed)).toBe(true);
    expect(hasUnsavedEdits(withSavedText(changed, "b", "n"))).toBe(false);
    expect(hasUnsavedEdits(undo(withSavedText(changed, "b", "n")))).toBe(true);
  });

  it("begins with a draft, and undoes to the file", () => {
    const h = newHistory("a", "m", "d");
    expect(h.text).toBe("d");
    expect(undo(h).text).toBe("a");
  });
});

describe("a file that another program writes", () => {
  it("is taken over where nothing is unsaved, and can be undone", () => {
    const { now, conflict } = mergeDiskText(start, "z", "n");
    expect(conflict).toBe(false);
    expect(now).toMatchObject({ text: "z", saved: "z", mark: "n" });
    expect(undo(now).text).toBe("a");
  });

  it("never takes the place of an unsaved edit", () => {
    const mine = withEdit(start, "b");
    const { now, conflict } = mergeDiskText(mine, "z", "n");
    expect(conflict).toBe(true);
    expect(now).toBe(mine);
  });

  it("is no conflict where it was only touched, or went away and came back", () => {
    const mine = withEdit(start, "b");
    expect(mergeDiskText(mine, "a", "m")).toEqual({ now: mine, conflict: false });
    expect(mergeDiskText({ ...mine, saved: "" }, "a", "m")).toEqual({ now: mine, conflict: false });
    // A draft of another text than the file's stays one, however often that is looked at.
    expect(mergeDiskText(newHistory("a", "older", "d"), "a", "m").conflict).toBe(true);
  });

  it("is no conflict where both say the same", () => {
    const { now, conflict } = mergeDiskText(withEdit(start, "b"), "b", "n");
    expect(conflict).toBe(false);
    expect(hasUnsavedEdits(now)).toBe(false);
  });
});
