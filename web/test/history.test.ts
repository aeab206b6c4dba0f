import { describe, expect, it } from "vitest";
import { edited, MOST, onDisk, opened, redone, undone, unsaved, written } from "../src/history";

const start = opened("a", "m", null);

describe("the document and its past", () => {
  it("goes back and comes back, step by step", () => {
    const two = edited(edited(start, "b"), "c");
    expect(undone(undone(two)).text).toBe("a");
    expect(redone(redone(undone(undone(two)))).text).toBe("c");
    expect(undone(undone(undone(two)))).toMatchObject({ text: "a", past: [] });
  });

  it("forgets what was undone once something new is done", () => {
    const again = edited(undone(edited(start, "b")), "c");
    expect(again.future).toEqual([]);
    expect(undone(again).text).toBe("a");
  });

  it("takes letters typed for one step", () => {
    const typed = edited(edited(edited(start, "ab"), "abc", true), "abcd", true);
    expect(undone(typed).text).toBe("a");
  });

  it("is the same where nothing changes", () => {
    expect(edited(start, "a")).toBe(start);
    expect(undone(start)).toBe(start);
    expect(redone(start)).toBe(start);
  });

  it("keeps no more steps than it should", () => {
    let h = start;
    for (let k = 0; k < MOST + 50; k++) h = edited(h, `${k}`);
    expect(h.past.length).toBe(MOST);
    expect(undone(h).text).toBe(`${MOST + 48}`);
  });

  it("knows what is saved", () => {
    const changed = edited(start, "b");
    expect(unsaved(start)).toBe(false);
    expect(unsaved(changed)).toBe(true);
    expect(unsaved(written(changed, "b", "n"))).toBe(false);
    expect(unsaved(undone(written(changed, "b", "n")))).toBe(true);
  });

  it("begins with a draft, and undoes to the file", () => {
    const h = opened("a", "m", "d");
    expect(h.text).toBe("d");
    expect(undone(h).text).toBe("a");
  });
});

describe("a file that another program writes", () => {
  it("is taken over where nothing is unsaved, and can be undone", () => {
    const { now, conflict } = onDisk(start, "z", "n");
    expect(conflict).toBe(false);
    expect(now).toMatchObject({ text: "z", saved: "z", mark: "n" });
    expect(undone(now).text).toBe("a");
  });

  it("never takes the place of an unsaved edit", () => {
    const mine = edited(start, "b");
    const { now, conflict } = onDisk(mine, "z", "n");
    expect(conflict).toBe(true);
    expect(now).toBe(mine);
  });

  it("is no conflict where it was only touched, or went away and came back", () => {
    const mine = edited(start, "b");
    expect(onDisk(mine, "a", "m")).toEqual({ now: mine, conflict: false });
    expect(onDisk({ ...mine, saved: "" }, "a", "m")).toEqual({ now: mine, conflict: false });
    // A draft of another text than the file's stays one, however often that is looked at.
    expect(onDisk(opened("a", "older", "d"), "a", "m").conflict).toBe(true);
  });

  it("is no conflict where both say the same", () => {
    const { now, conflict } = onDisk(edited(start, "b"), "b", "n");
    expect(conflict).toBe(false);
    expect(unsaved(now)).toBe(false);
  });
});
