import { beforeEach, describe, expect, it, vi } from "vitest";
import type { Store } from "../src/store";

interface Said {
  type: string;
  id: number;
  text: string;
  held?: boolean;
  drag?: { by_mm: number[] };
  edits?: Record<string, number>;
}

/** A socket that a test answers by hand. */
class Socket {
  static OPEN = 1;
  static last: Socket;
  readyState = 1;
  said: Said[] = [];
  onopen?: () => void;
  onclose?: () => void;
  onmessage?: (e: { data: string }) => void;
  constructor() {
    Socket.last = this;
  }
  send(data: string): void {
    this.said.push(JSON.parse(data) as Said);
  }
  tell(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
  asked(): Said[] {
    return this.said.filter((s) => s.type === "ask");
  }
  answer(text?: string): void {
    const q = this.said.filter((s) => s.type === "ask" || s.type === "pose").at(-1) as Said;
    if (q.held) {
      this.tell({ type: "moved", id: q.id, lines: [{ name: "main", angles: [[q.drag?.by_mm[2]]] }], obstacles: [] });
      this.tell({ type: "graded", id: q.id, limits: [{ id: "a", values: [[q.drag?.by_mm[2]]], margins: [[0]], grades: [[1]] }], grade: "warn" });
      return;
    }
    const moved = q.drag ? `${q.text}+${q.drag.by_mm[2]}` : q.edits ? `${q.text}*` : q.text;
    this.tell({ type: "live", id: q.id, text: text ?? moved, lines: [{ name: "main", joints: ["2040"], angles: [[0]] }], limits: [{ id: "a", name: "A", values: [[0]], margins: [[1]], grades: [[0]], points: [["here"]], spots: [[{ torque_Nm: -5, way: "reverse" }]] }], pending: [], states: [], obstacles: [], handles: [] });
  }
}

const kept = new Map<string, string>();
const box = { getItem: (k: string) => kept.get(k) ?? null, setItem: (k: string, v: string) => void kept.set(k, v) };

let store: Store;
let socket: Socket;
let leave: () => void;
let asked: boolean;
/** Close the page: whether it is asked first. */
let close: () => boolean;
const by = (z: number) => ({ drag: { kind: "bearing" as const, number: 1, line: "main", by_mm: [0, 0, z] as [number, number, number] } });

beforeEach(async () => {
  vi.resetModules();
  vi.useFakeTimers();
  kept.clear();
  vi.stubGlobal("WebSocket", Socket);
  vi.stubGlobal("location", { hash: "#token", pathname: "/", host: "127.0.0.1:1" });
  vi.stubGlobal("history", { replaceState: vi.fn() });
  vi.stubGlobal("sessionStorage", box);
  vi.stubGlobal("localStorage", box);
  vi.stubGlobal("navigator", { language: "en" });
  vi.stubGlobal("document", { documentElement: { dataset: {}, lang: "" }, getElementById: () => null });
  vi.stubGlobal("requestAnimationFrame", () => 0);
  vi.stubGlobal("addEventListener", (kind: string, heard: (e: object) => void) => {
    if (kind === "pagehide") leave = () => heard({});
    if (kind === "beforeunload") close = () => { asked = false; heard({ preventDefault: () => { asked = true; } }); return asked; };
  });
  store = new (await import("../src/store")).Store();
  store.connect();
  socket = Socket.last;
  socket.onopen?.();
  socket.tell({ type: "welcome", version: "1", token: "token", lang: "en", languages: ["en"], texts: {}, quantities: {}, files: ["a.yaml"] });
  socket.tell({ type: "opened", file: 0, name: "a.yaml", saved: "a", mark: "m", draft: null, stale: false });
  socket.answer();
  socket.said = [];
});

describe("a verdict that ends without the bearing forces", () => {
  it.each(["live", "full"])("is said to be unfinished after %s, until it is asked for again", (type) => {
    store.evaluateAgain();
    const [first] = socket.asked();
    if (type === "full") socket.answer();
    expect(store.known.unfinished).toBe("");
    socket.tell({ type, id: first?.id, fault: "too slow" });
    expect(store.known).toMatchObject({ settled: false, unfinished: expect.stringContaining("took too long") as string });
    store.evaluateAgain();
    socket.answer();
    expect(store.known).toMatchObject({ settled: false, unfinished: "" });
    socket.tell({ type: "full", id: socket.asked().at(-1)?.id, verdict: "pass", rows: [], limits: [] });
    expect(store.known).toMatchObject({ settled: true, unfinished: "" });
  });
});

describe("a hand that moves", () => {
  it("has one question under way, and asks the latest next", () => {
    for (let z = 1; z <= 20; z++) store.hold("h", by(z));
    expect(socket.asked().map((s) => s.drag?.by_mm[2])).toEqual([1]);
    socket.answer();
    expect(socket.asked().map((s) => s.drag?.by_mm[2])).toEqual([1, 20]);
    expect(store.known.history?.text).toBe("a");
  });

  it("is followed by the line, then by its limits; what stands still is not told again", () => {
    store.hold("h", by(3));
    store.hold("h", by(4));
    const [first] = socket.asked();
    socket.tell({ type: "moved", id: first?.id, lines: [{ name: "main", angles: [[3]] }], obstacles: [] });
    expect(store.known.live?.lines).toEqual([{ name: "main", joints: ["2040"], angles: [[3]] }]);
    expect(store.known.live?.limits[0]).toMatchObject({ values: [[0]], points: [["here"]] });
    expect(socket.asked().map((s) => s.drag?.by_mm[2])).toEqual([3, 4]);
    socket.tell({ type: "graded", id: first?.id, limits: [{ id: "a", values: [[9]], margins: [[-1]], grades: [[2]] }], grade: "fail" });
    expect(store.known.live).toMatchObject({ grade: "fail", lines: [{ angles: [[3]] }] });
    expect(store.rows()).toEqual([{ id: "a", name: "A", values: [[9]], margins: [[-1]], grades: [[2]] }]);
    socket.answer();
    expect(store.known.live).toMatchObject({ grade: "warn", lines: [{ angles: [[4]] }], limits: [{ values: [[4]] }] });
  });

  it("changes the document once, where it lets go", () => {
    store.hold("h", by(1));
    store.hold("h", by(2));
    store.release();
    socket.answer();
    socket.answer();
    expect(socket.asked().at(-1)).toMatchObject({ text: "a", drag: { by_mm: [0, 0, 2] } });
    expect(store.known.history).toMatchObject({ text: "a+2", past: ["a"] });
  });

  it("loses no change when it takes hold again before the last was answered", () => {
    store.hold("h", by(1));
    store.release();
    store.hold("g", by(5));
    store.release();
    for (let k = 0; k < 6; k++) socket.answer();
    expect(store.known.history).toMatchObject({ text: "a+1+5", past: ["a", "a+1"] });
  });

  it("puts everything back on escape", () => {
    store.hold("h", by(1));
    socket.answer();
    store.cancel();
    expect(socket.asked().at(-1)?.drag).toBeUndefined();
    socket.answer();
    expect(store.known.history).toMatchObject({ text: "a", past: [] });
  });

  it("keeps the document where a change cannot be", () => {
    store.hold("h", by(1));
    store.release();
    socket.answer();
    const q = socket.asked().at(-1) as Said;
    socket.tell({ type: "live", id: q.id, text: "a", problems: [{ message: "no", line: 0, column: 0, key: "at", value: "", hint: "" }] });
    expect(store.known.history?.text).toBe("a");
    expect(store.known.notice).toMatchObject({ kind: "refused", why: "at: no" });
    expect(socket.asked().at(-1)?.drag).toBeUndefined();
    // It stood there until somebody closed it, whatever was done since.
    socket.answer();
    store.hold("h", by(2));
    socket.answer();
    store.release();
    expect(store.known.notice).not.toBeNull();
    socket.answer();
    expect(store.known).toMatchObject({ notice: null, history: { text: "a+2" } });
  });
});

describe("a limit", () => {
  it("is looked at in its state and under the torque at which it is worst", () => {
    store.look({ row: "a", state: 0, part: 0 });
    const asked = socket.said.find((s) => s.type === "pose") as unknown as { pose: object };
    expect(asked.pose).toEqual({ line: 0, state: 0, torque_Nm: -5, way: "reverse" });
    expect(store.known.asked.state).toBe(0);
  });
});

describe("a slider", () => {
  const asked = () => socket.said.filter((s) => s.type === "pose") as (Said & { want?: string[] })[];
  const tell = (pose: object): void => socket.tell({ type: "posed", id: asked().at(-1)?.id, pose });

  it("is followed by the place alone, by its curves once it rests", () => {
    store.pose({ state: 0 });
    vi.runOnlyPendingTimers();
    tell({ line: 0, state: 0, travel: 0, over_travel: { x: [1] }, stuck: "no" });
    for (const travel_mm of [1, 2, 3]) store.pose({ travel_mm, torque_Nm: 0 });
    expect(asked().map((s) => s.want)).toEqual([undefined, []]);
    tell({ line: 0, state: null, travel: 1, at: { pitch: 1 } });
    expect(store.known.pose).toEqual({ line: 0, state: null, travel: 1, at: { pitch: 1 }, over_travel: { x: [1] } });
    tell({ line: 0, state: null, travel: 3, at: { pitch: 3 } });
    vi.advanceTimersByTime(1000);
    expect(asked().map((s) => s.want)).toEqual([undefined, [], [], undefined]);
    tell({ line: 0, state: null, travel: 3, at: { pitch: 3 }, over_travel: { x: [2] } });
    expect(store.known.pose).toMatchObject({ travel: 3, over_travel: { x: [2] } });
  });
});

describe("the document", () => {
  it("is kept as a draft a moment after a change, and no longer once it is as on disk", () => {
    store.apply({ x: 1 });
    socket.answer();
    vi.advanceTimersByTime(400);
    expect(socket.said.at(-1)).toMatchObject({ type: "keep", text: "a*", mark: "m" });
    store.undo();
    vi.advanceTimersByTime(400);
    expect(socket.said.at(-1)).toMatchObject({ type: "drop", file: 0 });
  });

  it("asks who counts where the disk is another, and obeys", () => {
    store.apply({ x: 1 });
    socket.answer();
    socket.tell({ type: "disk", file: 0, text: "z", mark: "n", conflict: false });
    expect(store.known.notice?.kind).toBe("conflict");
    expect(store.known.history?.text).toBe("a*");
    store.settle(false);
    expect(socket.said.at(-1)).toMatchObject({ type: "save", text: "a*", mark: "n" });
  });

  it("stays a draft where another tab saved its own and threw it away, and where the page is left at once", () => {
    store.apply({ x: 1 });
    socket.answer();
    leave();
    expect(socket.said.at(-1)).toMatchObject({ type: "keep", text: "a*", mark: "m" });
    socket.said = [];
    socket.tell({ type: "disk", file: 0, text: "z", mark: "n", conflict: false });
    vi.advanceTimersByTime(400);
    expect(socket.said.at(-1)).toMatchObject({ type: "keep", text: "a*", mark: "m" });
  });

  it("is kept while the file takes its place, until there is another or it is left", () => {
    store.apply({ x: 1 });
    socket.answer();
    socket.tell({ type: "disk", file: 0, text: "z", mark: "n", conflict: false });
    vi.advanceTimersByTime(400);
    socket.said = [];
    store.settle(true);
    vi.advanceTimersByTime(400);
    expect(store.known.history).toMatchObject({ text: "z", saved: "z" });
    expect(socket.said.filter((s) => s.type === "drop")).toEqual([]);
    leave();
    expect(socket.said.at(-1)).toMatchObject({ type: "drop", file: 0 });
  });

  it("has no conflict with a touched file, nor any more where the disk says again what it said", () => {
    store.apply({ x: 1 });
    socket.answer();
    socket.tell({ type: "disk", file: 0, text: "a", mark: "m", conflict: false });
    expect(store.known.notice).toBeNull();
    socket.tell({ type: "disk", file: 0, text: "z", mark: "n", conflict: false });
    expect(store.known.notice?.kind).toBe("conflict");
    socket.tell({ type: "disk", file: 0, text: "a", mark: "m", conflict: false });
    expect(store.known.notice).toBeNull();
    expect(store.known.history?.text).toBe("a*");
  });

  it("is asked about again where a file that it names is another, and so is what was answered of it", () => {
    const of = store.about({});
    socket.tell({ type: "beside", file: 0 });
    expect(socket.asked().map((s) => s.text)).toEqual(["a"]);
    expect(store.known.notice?.kind).toBe("beside");
    expect(store.about({})).not.toBe(of);
  });

  it("is not closed unasked while an edit is kept nowhere else, which is said once", () => {
    store.apply({ x: 1 });
    socket.answer();
    expect(close()).toBe(false); // it is kept on the way out
    vi.advanceTimersByTime(400);
    socket.tell({ type: "refused", what: "keep", file: 0, why: "no space" });
    expect(store.known.notice).toMatchObject({ kind: "refused", why: expect.stringContaining("no space") });
    expect(close()).toBe(true);
    store.dismiss();
    socket.tell({ type: "refused", what: "keep", file: 0, why: "no space" });
    expect(store.known.notice).toBeNull();
    socket.tell({ type: "kept", file: 0 });
    expect(close()).toBe(false);
    socket.onclose?.();
    expect(close()).toBe(false); // that text is kept
    store.type("more", false);
    expect(close()).toBe(true);
    vi.advanceTimersByTime(5000);
    Socket.last.onopen?.();
    Socket.last.tell({ type: "welcome", version: "1", token: "token", lang: "en", languages: ["en"], texts: {}, quantities: {}, files: ["a.yaml"] });
    Socket.last.tell({ type: "opened", file: 0, name: "a.yaml", saved: "a", mark: "m", draft: "a*", stale: false });
    expect(store.known.notice).toBeNull();
    Socket.last.onclose?.();
    expect(close()).toBe(true); // another text is kept
    Socket.last.onopen?.();
    store.type("a*", false);
    Socket.last.onclose?.();
    expect(close()).toBe(false);
    Socket.last.onopen?.();
    store.type("more", false);
    vi.advanceTimersByTime(400);
    expect(Socket.last.said.at(-1)).toMatchObject({ type: "keep", text: "more" });
  });

  it("is without a change that is undone before it is made, and shown so", () => {
    store.type("b", false);
    socket.answer();
    store.apply({ x: 1 });
    store.apply({ y: 1 });
    store.undo();
    store.undo();
    for (let k = 0; k < 3; k++) socket.answer();
    expect(store.known.history).toMatchObject({ text: "b", past: ["a"] });
    expect(socket.asked().at(-1)).toMatchObject({ text: "b" });
    expect(socket.asked().at(-1)?.edits).toBeUndefined();
  });

  it("loses neither what was typed nor a change that was on its way then, and is what is shown", () => {
    store.apply({ x: 1 });
    store.type("typed", false);
    for (let k = 0; k < 3; k++) socket.answer();
    expect(store.known.history?.text).toBe("typed*");
    expect(socket.asked().at(-1)?.text).toBe("typed*");
  });

  it("can be saved again where it is gone from the disk", () => {
    socket.tell({ type: "refused", what: "read", file: 0, why: "is no longer there" });
    expect(store.known.notice).toMatchObject({ kind: "refused", why: expect.stringContaining("Save writes it again") });
    expect(store.known.history).toMatchObject({ text: "a", saved: "" });
  });

  it("is asked about again after the connection was lost, with what is on the page", () => {
    store.apply({ x: 1 });
    socket.answer();
    socket.onclose?.();
    vi.advanceTimersByTime(5000);
    const again = Socket.last;
    expect(again).not.toBe(socket);
    again.onopen?.();
    again.tell({ type: "welcome", version: "1", token: "token", lang: "en", languages: ["en"], texts: {}, quantities: {}, files: ["a.yaml"] });
    again.tell({ type: "opened", file: 0, name: "a.yaml", saved: "a", mark: "m", draft: null, stale: false });
    expect(store.known.history?.text).toBe("a*");
    expect(again.asked().at(-1)?.text).toBe("a*");
  });

  it("saves what an editor has not told yet", () => {
    store.pending = () => store.type("typed", false);
    store.save();
    expect(socket.said.at(-1)).toMatchObject({ type: "save", text: "typed" });
  });

  it("is never mixed with another: an answer of the one before changes nothing", () => {
    store.hold("h", by(1));
    store.release();
    const late = socket.asked().at(-1) as Said;
    store.apply({ x: 1 });
    socket.tell({ type: "opened", file: 0, name: "b.yaml", saved: "b", mark: "n", draft: null, stale: false });
    socket.tell({ type: "live", id: late.id, text: "a+1", lines: [], limits: [], pending: [], states: [], obstacles: [], handles: [] });
    expect(store.known.history).toMatchObject({ text: "b", past: [] });
    socket.answer();
    expect(store.known.history).toMatchObject({ text: "b", past: [] });
  });

  it("is kept at once where another one is opened", () => {
    store.apply({ x: 1 });
    socket.answer();
    store.open(0);
    expect(socket.said.slice(-2)).toMatchObject([{ type: "keep", file: 0, text: "a*" }, { type: "open" }]);
  });

  it("takes along a change that is on its way where another one is opened at once", () => {
    store.apply({ "a.b": 1 });
    store.hold("h", by(2));
    store.open(1);
    expect(socket.said.filter((s) => s.type === "open")).toEqual([]);
    socket.answer();
    socket.answer();
    expect(socket.said.slice(-2)).toMatchObject([{ type: "keep", file: 0, text: "a*+2" }, { type: "open", file: 1 }]);
    expect(socket.said.filter((s) => s.type === "open")).toHaveLength(1);
  });

  it("is not taken for another one that the disk tells of after it was left", () => {
    socket.tell({ type: "disk", file: 1, text: "another", mark: "n", conflict: false });
    socket.tell({ type: "saved", file: 1, text: "another", mark: "n" });
    expect(store.known.history).toMatchObject({ text: "a", saved: "a", mark: "m" });
  });

  it("is helped by what was asked of it, not of what it was", () => {
    store.help();
    const late = socket.said.at(-1) as Said;
    store.type("b", false);
    socket.tell({ type: "helped", id: late.id, helps: [{ name: "old" }] });
    expect(store.known.helps).toBeNull();
    socket.answer();
    store.help();
    socket.tell({ type: "helped", id: socket.said.at(-1)?.id, helps: [{ name: "new" }] });
    expect(store.known).toMatchObject({ helping: false, helps: [{ name: "new" }] });
  });

  it("takes the verdict of the latest question alone", () => {
    const first = store.known;
    socket.tell({ type: "full", id: 99, text: "a", verdict: "pass", counted: {}, limits: [], others: [], notes: [], missed: 0, unanswered: [] });
    expect(store.known.settled).toBe(first.settled);
    socket.tell({ type: "full", id: 1, text: "a", verdict: "pass", counted: {}, limits: [], others: [], notes: [], missed: 0, unanswered: [] });
    expect(store.known.settled).toBe(true);
  });
});

describe("what is shown first", () => {
  const full = { type: "full", text: "a", verdict: "fail", counted: {}, others: [], notes: [], missed: 0, unanswered: [] };
  const sought = { id: "b", name: "B", line: "main", values: [[1], [2], [3]], margins: [[-9], [-0.1], [-0.4]], grades: [[1], [2], [2]] };

  it("is the state of the worst limit: a failure before a warning of a smaller margin", () => {
    socket.tell({ ...full, id: 1, limits: [sought] });
    expect(store.known.asked).toEqual({ line: 0, state: 2 });
  });

  it("stays what somebody chose meanwhile, and after every later verdict", () => {
    store.pose({ line: 0, state: 1 });
    socket.tell({ ...full, id: 1, limits: [sought] });
    expect(store.known.asked).toEqual({ line: 0, state: 1 });
    socket.tell({ ...full, id: 1, limits: [{ ...sought, grades: [[2], [0], [0]] }] });
    expect(store.known.asked).toEqual({ line: 0, state: 1 });
  });

  it("does not jump under a hand", () => {
    store.hold("h", by(1));
    socket.tell({ ...full, id: socket.said.at(-1)?.id, limits: [sought] });
    expect(store.known.asked).toEqual({});
  });
});

describe("a job", () => {
  const tell = (what: object): void => socket.tell({ type: "done", id: socket.said.at(-1)?.id, job: "map", ...what });

  it("that was stopped can be asked again; an answer of before is still of what it was", () => {
    store.work("map", { x: 1 });
    tell({ found: 1 });
    store.type("b", false);
    store.work("map", { x: 1 });
    tell({ fault: "cancelled" });
    expect(store.known.jobs.map).toMatchObject({ running: false, why: "stopped", answer: { found: 1 } });
    expect(store.known.jobs.map?.of).toBe(store.about({ x: 1 }, "a"));
    socket.said = [];
    store.work("map", { x: 1 });
    expect(socket.said).toMatchObject([{ type: "job", text: "b" }]);
  });
});

describe("what is more than is taken", () => {
  const welcome = { type: "welcome", token: "t", who: "w", longest: 50, texts: {}, lang: "en", languages: [], quantities: {}, catalogue: {}, profiles: [], files: [] };

  it("stands for itself by its size, so that the server can refuse it and stays", () => {
    socket.tell(welcome);
    socket.said = [];
    store.work("map", { x: "y".repeat(100) }, "text");
    expect(socket.said).toMatchObject([{ type: "job", job: "map", bytes: expect.any(Number) }]);
    expect(socket.said[0]).not.toHaveProperty("text");
    socket.tell({ type: "done", id: socket.said[0]?.id, job: "map", fault: "too long a text" });
    expect(store.known.jobs.map).toMatchObject({ running: false, why: "too long a text" });
  });

  it("is said of the thirteenth variant, which is not kept in silence", () => {
    socket.tell({ type: "opened", file: 0, name: "a.yaml", saved: "a", mark: "m", draft: null, stale: false, variants: [], revisions: [] });
    for (let k = 0; k < 13; k++) store.beside(`${k}`, "x");
    expect(store.known.variants).toHaveLength(12);
    expect(store.known.notice).toMatchObject({ kind: "refused" });
    store.rename(0, "  ");
    expect(store.known.variants[0]?.name).toBe("0");
  });

  it("comes back as who it was", () => {
    socket.tell(welcome);
    socket.onclose?.();
    vi.advanceTimersByTime(5000);
    Socket.last.onopen?.();
    expect(Socket.last.said).toMatchObject([{ type: "hello", was: "w" }]);
  });
});
