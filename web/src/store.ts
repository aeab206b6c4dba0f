// What the page knows, and all it does. One question is under way; the latest one goes next.

import * as History from "./history";
import { showHiddenMarks, setNumberLanguage } from "./format";
import { StaticConnection } from "./staticConnection";
import { SocketConnection, type ConnectionState, sessionToken } from "./socket";
import { setTexts, t } from "./i18n";
import type { Campaign, Drag, Edits, Full, Handle, Help, Limit, Live, Named, Pose, PoseRequest, Problem, EvaluationRequest, Revision, Row, Spot, ServerMessage, Welcome } from "./types";

/** `inStrip` says whether it was chosen beside the verdict: its detail opens where it was chosen. */
export interface SelectedCell { row: string; state: number; part: number; inStrip?: boolean }

export type Notice =
  | { kind: "restored" | "elsewhere"; left: number }
  | { kind: "conflict"; text: string; mark: string }
  | { kind: "reloaded" }
  | { kind: "beside" }
  | { kind: "refused"; why: string };

export interface AppState extends Welcome {
  connection: ConnectionState;
  file: number | null;
  history: History.EditHistory | null;
  live: Live | null;
  /** What a file of recordings names: then nothing is live. */
  campaign: Campaign | null;
  handles: Handle[];
  full: Full | null;
  /** Whether the verdict is of what is shown, or of what it was before. */
  settled: boolean;
  /** Why the verdict of what is shown ended without the bearing forces; "" while it may still come. */
  unfinished: string;
  pose: Pose | null;
  asked: PoseRequest;
  problems: Problem[];
  helps: Help[] | null;
  helping: boolean;
  selected: SelectedCell | null;
  order: string[];
  notice: Notice | null;
  held: string | null;
  theme: "auto" | "light" | "dark";
  view: View;
  /** Whether nobody answers and nothing can be changed: a page by itself. */
  fixed: boolean;
  jobs: Record<string, Job>;
  /** A recording on its way to the server, or there. */
  parcel: { id: number; name: string; got: number; size: number } | null;
  variants: Named[];
  revisions: Revision[];
  /** Whether a revision is being written: what it names may take long to be read. */
  freezing: boolean;
  /** How often a file that this one names has changed meanwhile: what was answered is of the last. */
  beside: number;
  /** Which variant is drawn behind what is shown. */
  behind: number | null;
}

export const VIEWS = ["line", "speed", "change", "variants", "bracket", "recording", "limits", "library", "new"] as const;
export type View = (typeof VIEWS)[number];

/** What takes long: its answer, or what of it is known so far. */
export interface Job<Answer = unknown, Part = unknown> {
  id: number;
  /** What it was asked about, the text and the arguments; of what its answer is where it ended without one. */
  of: string;
  was: string;
  running: boolean;
  part: Part | null;
  answer: Answer | null;
  why: string;
  problems?: Problem[] | undefined;
}

/** Whether a file is a CAN database, which decodes the frames of a log. */
export const isDatabase = (name: string): boolean => name.toLowerCase().endsWith(".dbc");

const start: AppState = {
  connection: "opening", version: "", lang: "en", languages: ["en"], quantities: {},
  catalogue: { joints: [], tubes: [] }, profiles: [], missing: [], bracket_example: "", files: [], file: null, history: null, live: null, campaign: null, handles: [],
  full: null, settled: false, unfinished: "", pose: null, asked: {}, problems: [], helps: null, helping: false, selected: null,
  order: [], notice: null, held: null, theme: "auto", view: "line", fixed: false, jobs: {}, parcel: null, variants: [], revisions: [], freezing: false,
  beside: 0, behind: null,
};

interface Gesture {
  name: string;
  /** The text it began from; null while an earlier change is still being answered. */
  base: string | null;
  change: { drag?: Drag; edits?: Edits };
  want: "turn"[];
}

/** `shown` says whether what was asked for is on the page before the answer. */
interface Waiting { kind: "ask" | "pose"; question: EvaluationRequest; commit: boolean; since: number; shown?: boolean }

interface Sent extends Waiting { id: number }

/** How long a slider rests before the curves beside it are asked for, in ms. */
const REST = 200;

/** Ask a browser for what it keeps; one that keeps nothing is asked again next time. */
function kept<T>(ask: () => T): T | null {
  try { return ask(); } catch { return null; }
}

export const readPreference = (key: string): string | null => kept(() => localStorage.getItem(key));

export const writePreference = (key: string, value: string): void => { kept(() => localStorage.setItem(key, value)); };

export class Store {
  known: AppState = start;
  private readonly watchers = new Set<() => void>();
  private link: SocketConnection | StaticConnection | null = null;
  private ids = 0;
  private sent: Sent | null = null;
  private next: Waiting | null = null;
  /** What must not be lost: each is made of the document as it is when its turn comes. */
  private commits: Waiting[] = [];
  private gesture: Gesture | null = null;
  private keeping: ReturnType<typeof setTimeout> | undefined;
  private latest = 0;
  /** What an editor has not told yet: asked for before anything that counts on the text. */
  pending: (() => void) | null = null;

  watch(watcher: () => void): () => void {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }

  private set(change: Partial<AppState>): void {
    this.known = { ...this.known, ...change };
    for (const watcher of this.watchers) watcher();
  }

  // ------------------------------------------------------------------ the socket

  connect(): void {
    const theme = readPreference("cardan-theme");
    if (theme === "light" || theme === "dark") this.theme(theme);
    const kept = document.getElementById("live")?.textContent;
    const told = (m: ServerMessage): void => this.told(m);
    const connected = (c: ConnectionState): void => this.connected(c);
    this.link = kept ? new StaticConnection(kept, told, connected) : new SocketConnection(sessionToken(), told, connected);
    this.set({ fixed: Boolean(kept) });
    addEventListener("pagehide", () => { if (this.aside || (this.known.history && History.hasUnsavedEdits(this.known.history))) this.keepNow(); });
    addEventListener("beforeunload", (e) => { if (this.losing()) e.preventDefault(); });
    this.link.open();
  }

  private connected(connection: ConnectionState): void {
    this.sent = this.next = null;
    this.commits = [];
    this.set({ connection, jobs: {}, parcel: null, freezing: false });
    if (connection === "open") {
      const lang = readPreference("cardan-lang") ?? navigator.language.slice(0, 2);
      this.link?.say({ type: "hello", lang, was: this.who });
    }
  }

  /** As whom this page keeps what is not saved, apart from other pages. */
  private who = "";

  private told(m: ServerMessage): void {
    // What is told of a file that was left meanwhile is not of this one.
    if ((m.type === "saved" || m.type === "disk" || m.type === "beside" || m.type === "frozen") && m.file !== this.known.file) return;
    switch (m.type) {
      case "welcome":
        setTexts(m.texts);
        setNumberLanguage(m.lang);
        this.who = m.who;
        document.documentElement.lang = m.lang === "pt" ? "pt-BR" : m.lang;
        this.set({ version: m.version, lang: m.lang, languages: m.languages, quantities: m.quantities, catalogue: m.catalogue, profiles: m.profiles, missing: m.missing ?? [], bracket_example: m.bracket_example ?? "", files: m.files.map(showHiddenMarks) });
        if (this.known.file !== null) this.rejoin(this.known.file);
        else if (m.files.length === 1) this.open(0);
        break;
      case "opened": return this.opened(m);
      case "graded": return this.graded(m);
      case "moved":
      case "live":
      case "posed":
        this.answered(m);
        break;
      case "full":
        if (m.id === this.latest && m.verdict) {
          const [full, first] = [m as Full, this.known.full === null];
          this.set({ full, settled: true, unfinished: "", order: this.sorted(full) });
          // What stands first in the verdict is shown, unless something has been chosen meanwhile.
          const [row] = this.rows();
          if (first && row?.values && !this.gesture && Object.keys(this.known.asked).length === 0) this.go(row, worstState(row));
        } else if (m.id === this.latest) {
          this.set({ unfinished: m.fault === undefined ? (m.problems?.[0]?.message ?? "?") : faulty(m.fault) });
        }
        break;
      case "helped":
        if (m.id === this.latest) this.set({ helping: false, helps: m.helps ?? this.known.helps });
        break;
      case "saved": {
        const history = this.known.history;
        if (history) this.set({ history: History.withSavedText(history, m.text, m.mark), notice: null });
        break;
      }
      case "kept":
        [this.unkept, this.safe] = [false, this.keptLast];
        break;
      case "beside":
        this.set({ beside: this.known.beside + 1, notice: this.known.notice ?? { kind: "beside" } });
        if (this.known.history) this.ask({ text: this.known.history.text });
        break;
      case "disk": return this.disk(m.text, m.mark, m.conflict);
      case "refused":
        if (m.what === "keep") {
          // Told once: who has read it need not close it after each letter.
          if (!this.unkept && this.known.notice?.kind !== "conflict") this.set({ notice: { kind: "refused", why: t("Unsaved changes are in this page only and cannot be kept: {why}", { why: faulty(m.why) }) } });
          [this.unkept, this.safe] = [true, null];
          break;
        }
        // What is gone from the disk is as good as never saved.
        if (m.what === "read" && this.known.history) this.set({ history: { ...this.known.history, saved: "" } });
        this.set({ notice: { kind: "refused", why: faulty(m.why) }, parcel: m.what === "bring" ? null : this.known.parcel, freezing: this.known.freezing && m.what !== "freeze" });
        break;
      case "brought": return this.brought(m.id, m.got);
      case "frozen":
        this.set({ revisions: m.revisions, freezing: false });
        break;
      case "files":
        this.set({ files: m.files.map(showHiddenMarks), view: "line" });
        break;
      case "part":
        this.worked(m.job, m.id, { part: { ...(this.known.jobs[m.job]?.part as object | null), ...m.part } });
        break;
      case "done": {
        // What is held side by side has its life by now.
        if (m.job === "campaign") this.set({ jobs: (({ compare: _, ...rest }) => rest)(this.known.jobs) });
        const why = m.fault ? faulty(m.fault) : (m.problems?.[0]?.message ?? "");
        this.worked(m.job, m.id, why ? { running: false, why, problems: m.problems, of: this.known.jobs[m.job]?.was ?? "" } : { running: false, answer: m, why });
        break;
      }
    }
  }

  // ------------------------------------------------------------------ what takes long

  /** Ask for a job, unless it is under way or answered already; a newer one takes its place. */
  work(job: string, args: object = {}, text = this.known.history?.text ?? "", file?: number): void {
    const of = this.about({ ...args, ...(file === undefined ? {} : { file }) }, text);
    const now = this.known.jobs[job];
    if (now?.of === of && (now.running || now.answer)) return;
    if (now?.running) this.link?.say({ type: "cancel", id: now.id });
    this.ids += 1;
    const next: Job = { id: this.ids, of, was: now?.running ? now.was : (now?.of ?? ""), running: true, part: null, answer: now?.answer ?? null, why: "" };
    this.set({ jobs: { ...this.known.jobs, [job]: next } });
    this.link?.say({ type: "job", id: this.ids, job, text, args, ...(file === undefined ? {} : { file }) });
  }

  // ------------------------------------------------------------------ a recording

  private bringing: File | null = null;
  private recording: File | null = null;
  private following: File[] = [];

  /** Send a recording to the server, CAN databases first; databases alone are of the recording that is there. */
  take(files: File[]): void {
    const databases = files.filter((f) => isDatabase(f.name));
    const recording = files.find((f) => !isDatabase(f.name)) ?? (this.known.parcel ? this.recording : null);
    this.recording = recording;
    const [first, ...following] = [...databases, ...(recording ? [recording] : [])];
    this.following = following;
    if (first) this.bring(first);
  }

  /** Send a file to the server, piece by piece, in place of the last. */
  private bring(file: File): void {
    this.bringing = file;
    this.ids += 1;
    for (const job of ["recording", "life"]) this.stop(job);
    const { recording: _, life: __, ...jobs } = this.known.jobs;
    this.set({ jobs, parcel: { id: this.ids, name: file.name, got: 0, size: file.size }, notice: this.known.notice?.kind === "refused" ? null : this.known.notice });
    this.link?.say({ type: "bring", id: this.ids, name: file.name.slice(-200), size: file.size });
  }

  private brought(id: number, got: number): void {
    const [file, parcel] = [this.bringing, this.known.parcel];
    if (!file || parcel?.id !== id) return;
    this.set({ parcel: { ...parcel, got } });
    if (got >= file.size) {
      const next = this.following.shift();
      if (next) this.bring(next);
      return;
    }
    const reader = new FileReader();
    reader.onload = () => { if (this.known.parcel?.id === id) this.link?.say({ type: "piece", at: got, data: String(reader.result).split(",")[1] ?? "" }); };
    reader.onerror = () => this.set({ parcel: null, notice: { kind: "refused", why: t("{file} cannot be read", { file: file.name }) } });
    reader.readAsDataURL(file.slice(got, got + 1_000_000));
  }

  /** What a job is about: another text, argument or language is another job. */
  about(args: object, text = this.known.history?.text): string { return JSON.stringify([text, args, this.known.lang, this.known.beside]); }

  /** Make the edits that a job found, once. */
  taken(job: string, edits: Edits): void {
    const { [job]: _, ...jobs } = this.known.jobs;
    this.set({ jobs });
    if (Object.keys(edits).length) this.apply(edits);
  }

  // ------------------------------------------------------------------ variants

  private keepVariants(variants: Named[]): void {
    this.set({ variants });
    if (this.known.file !== null) this.link?.say({ type: "pin", file: this.known.file, variants });
  }

  pin(): void {
    this.pending?.();
    const { variants, history } = this.known;
    if (history) this.beside(String.fromCharCode(65 + variants.length), history.text);
  }

  beside(name: string, text: string): void {
    const { variants } = this.known;
    if (variants.length >= VARIANTS) return this.set({ notice: { kind: "refused", why: t("up to {count} variants are kept: delete one first", { count: VARIANTS }) } });
    this.keepVariants([...variants, { name, text }]);
    this.lay(variants.length);
  }

  freeze(by: string, note: string): void {
    this.pending?.();
    const { file, history } = this.known;
    if (!history || file === null) return;
    this.set({ freezing: true });
    this.link?.say({ type: "freeze", file, text: history.text, by, note });
  }

  rename(k: number, name: string): void { this.keepVariants(this.known.variants.map((v, i) => (i === k ? { ...v, name: name.trim() || v.name } : v))); }

  unpin(k: number): void {
    this.lay(null);
    this.keepVariants(this.known.variants.filter((_, i) => i !== k));
  }

  lay(behind: number | null): void {
    this.set({ behind });
    const text = behind === null ? undefined : this.known.variants[behind]?.text;
    if (text !== undefined && this.known.live) this.work("ghost", {}, text);
  }

  create(title: string, text: string): void { this.link?.say({ type: "create", title, text }); }

  stop(job: string): void {
    const now = this.known.jobs[job];
    if (now?.running) this.link?.say({ type: "cancel", id: now.id });
  }

  private worked(job: string, id: number, change: Partial<Job>): void {
    const now = this.known.jobs[job];
    if (now?.id === id) this.set({ jobs: { ...this.known.jobs, [job]: { ...now, ...change } } });
  }

  /** What an editor has not told yet goes with it: it is asked for first. */
  show(view: View): void {
    this.pending?.();
    // A detail beside the verdict would push what was asked for below the screen.
    const selected = this.known.selected?.inStrip ? null : this.known.selected;
    this.set({ view, selected });
  }

  private opened(m: Extract<ServerMessage, { type: "opened" }>): void {
    const mine = this.known.history;
    this.safe = m.draft;
    if (mine && this.rejoining) {
      // The server was away: what is on the page is newer than any draft.
      this.rejoining = false;
      const { now, conflict } = History.mergeDiskText(mine, m.saved, m.mark);
      this.set({ history: now, notice: conflict ? { kind: "conflict", text: m.saved, mark: m.mark } : this.known.notice });
      this.ask({ text: now.text });
      if (History.hasUnsavedEdits(now)) this.keep(); // what was typed meanwhile
      return;
    }
    // Nothing that was under way is of this document.
    this.sent = this.next = this.gesture = null;
    this.commits = [];
    // What was edited from another text is still that: it is not saved over this one unasked.
    const history = History.newHistory(m.saved, m.stale ? m.base : m.mark, m.draft);
    const restored: Notice = m.stale ? { kind: "conflict", text: m.saved, mark: m.mark } : { kind: m.elsewhere ? "elsewhere" : "restored", left: m.left };
    this.set({
      file: m.file, history, notice: m.draft === null ? null : restored, live: null, campaign: null, full: null, settled: false, unfinished: "", pose: null, asked: {}, problems: [], helps: null, selected: null, order: [], held: null, behind: null,
      jobs: Object.fromEntries(Object.entries(this.known.jobs).filter(([job]) => job === "recording" || job === "life")),
      variants: m.variants, revisions: m.revisions,
    });
    this.ask({ text: history.text });
  }

  private rejoining = false;

  private rejoin(file: number): void {
    this.rejoining = this.known.history !== null;
    this.link?.say({ type: "open", file });
  }

  private disk(text: string, mark: string, conflict: boolean): void {
    this.pending?.();
    const history = this.known.history;
    if (!history) return;
    const found = History.mergeDiskText(history, text, mark);
    if (found.conflict || (conflict && text !== history.text)) {
      this.set({ notice: { kind: "conflict", text, mark } });
      this.keep(); // who saved it, in another tab, threw the draft away
    } else if (found.now.text !== history.text) {
      this.set({ history: found.now, notice: { kind: "reloaded" } });
      this.ask({ text: found.now.text });
    } else {
      this.set({ history: found.now, notice: this.known.notice?.kind === "conflict" ? null : this.known.notice });
    }
  }

  // ------------------------------------------------------------------ questions

  /** Compute the verdict of what is shown again, after it ended without one. */
  evaluateAgain(): void {
    if (this.known.history) this.ask({ text: this.known.history.text });
  }

  private ask(question: EvaluationRequest, how: { commit?: boolean; since?: number } = {}): void {
    this.put({ kind: "ask", question: { pose: this.known.asked, ...question }, commit: how.commit ?? false, since: how.since ?? performance.now() });
  }

  private put(waiting: Waiting): void {
    if (!this.sent) this.send(waiting);
    else if (waiting.commit) this.commits.push(waiting);
    else this.next = { ...waiting, since: this.next?.since ?? waiting.since };
  }

  private send(waiting: Waiting): void {
    this.ids += 1;
    const { kind, since } = waiting;
    const now = this.known.history?.text;
    // A hand goes from where it took hold; all else is about the document as it is.
    const question = waiting.question.held || now === undefined ? waiting.question : { ...waiting.question, text: now };
    this.sent = { ...waiting, question, id: this.ids };
    if (kind === "ask") {
      this.latest = this.ids;
      if (question.held) this.moves.set(this.ids, since);
      else this.moves.clear();
      if (this.known.settled || this.known.helping || this.known.unfinished) this.set({ settled: false, helping: false, unfinished: "" });
    }
    this.link?.say({ type: kind, id: this.ids, ...question });
  }

  /** Where a hand has the line; what its limits make of that comes by itself. */
  private moved(m: Extract<ServerMessage, { type: "moved" }>): void {
    const { live, pose } = this.known;
    if (!live) return;
    const lines = live.lines.map((l) => ({ ...l, ...m.lines?.find((o) => o.name === l.name) }));
    this.set({ live: { ...live, lines, obstacles: m.obstacles ?? [] }, problems: [], ...(m.pose ? { pose: posed(pose, m.pose) } : {}) });
  }

  /** When each move that a hand is making was made, by its question; none once it has let go. */
  private moves = new Map<number, number>();

  private graded(m: Extract<ServerMessage, { type: "graded" }>): void {
    const [{ live }, since] = [this.known, this.moves.get(m.id)];
    if (!live || since === undefined || !m.limits) return;
    const found = new Map(m.limits.map((r) => [r.id, r]));
    // Where a value was worst is said again once the hand rests.
    const limits = live.limits.map(({ points: _, spots: __, ...row }) => ({ ...row, ...found.get(row.id) }));
    this.set({ live: { ...live, limits, grade: m.grade ?? null } });
    painted(since);
  }

  private answered(m: Extract<ServerMessage, { type: "live" | "moved" | "posed" }>): void {
    const sent = this.sent;
    if (!sent || sent.id !== m.id) return;
    if (m.type === "posed") {
      if (m.pose) this.set({ pose: sent.question.want ? posed(this.known.pose, m.pose) : m.pose });
    } else if (m.problems) {
      this.set({ problems: m.problems });
      if (sent.commit) this.back();
    } else if (m.type === "moved" && m.lines) {
      this.moved(m);
    } else if (sent.commit && sent.question.text !== this.known.history?.text) {
      this.commits.unshift(sent); // of another text by now: made again, of that one
    } else if (m.type === "live" && m.fault === undefined && (m.lines || m.campaign)) {
      this.took(m, sent);
    }
    if (m.fault !== undefined) this.set({ notice: { kind: "refused", why: faulty(m.fault) }, ...(sent.id === this.latest ? { unfinished: faulty(m.fault) } : {}) });
    if (!sent.shown) painted(sent.since, m.type === "moved" ? "cardan:moved" : undefined);
    this.onward();
  }

  private onward(): void {
    this.sent = null;
    const commit = this.commits.shift();
    if (!commit && this.leaving !== null) return this.open(this.leaving);
    const next = commit ?? this.next;
    if (!commit) this.next = null;
    if (next) this.send(next);
  }

  private took(m: Extract<ServerMessage, { type: "live" }>, sent: Sent): void {
    const change: Partial<AppState> = { live: m.campaign ? null : (m as Live), campaign: m.campaign ?? null, problems: [] };
    if (m.handles) change.handles = m.handles;
    if (m.pose) change.pose = m.pose;
    if (sent.commit && this.known.history && m.text !== undefined) {
      change.history = History.withEdit(this.known.history, m.text);
      change.helps = null;
      if (this.known.notice?.kind === "refused") change.notice = null; // of what was tried before
    }
    this.set(change);
    if (sent.commit) {
      this.keep();
      if (this.gesture && this.gesture.base === null && this.known.history) {
        this.gesture.base = this.known.history.text;
        this.held();
      }
    }
  }

  /** Show the document as it is: a change could not be made. */
  private back(): void {
    const history = this.known.history;
    const problems = this.known.problems;
    if (!history) return;
    const [first] = problems;
    if (first) this.set({ notice: { kind: "refused", why: problemText(first) } });
    this.ask({ text: history.text });
  }

  // ------------------------------------------------------------------ hands

  /** Something is held and has been moved so far; the document waits until it is let go. */
  hold(name: string, change: { drag?: Drag; edits?: Edits }, want: "turn"[] = []): void {
    if (!this.known.history) return;
    if (!this.gesture || this.gesture.name !== name) {
      if (this.gesture) this.release();
      const busy = this.sent?.commit || this.commits.length > 0;
      this.gesture = { name, base: busy ? null : this.known.history.text, change, want };
      this.set({ held: name });
    }
    this.gesture.change = change;
    this.held();
  }

  private held(): void {
    const g = this.gesture;
    if (!g || g.base === null) return;
    this.ask({ text: g.base, ...g.change, held: true, want: g.want });
  }

  release(): void {
    const g = this.gesture;
    this.gesture = null;
    if (!g) return;
    this.set({ held: null });
    const base = g.base ?? this.known.history?.text;
    if (base !== undefined) this.ask({ text: base, ...g.change }, { commit: true });
  }

  cancel(): void {
    if (!this.gesture) return;
    this.gesture = null;
    this.set({ held: null });
    if (this.known.history) this.ask({ text: this.known.history.text });
  }

  apply(edits: Edits): void {
    const history = this.known.history;
    if (history) this.ask({ text: history.text, edits }, { commit: true });
  }

  // ------------------------------------------------------------------ the document

  open(file: number): void {
    this.rejoining = false;
    this.pending?.();
    this.release();
    // A change that is on its way would be lost with the document: it is made first.
    const busy = this.sent?.commit || this.commits.length > 0;
    this.leaving = busy ? file : null;
    if (busy) return;
    if (this.keeping !== undefined || this.aside) this.keepNow();
    this.link?.say({ type: "open", file });
  }

  private leaving: number | null = null;

  private now(history: History.EditHistory): void {
    if (history === this.known.history) return;
    this.shown(history);
    this.keep();
  }

  private shown(history: History.EditHistory): void {
    this.set({ history, helps: null });
    this.ask({ text: history.text });
  }

  type(text: string, merge: boolean): void { if (this.known.history) this.now(History.withEdit(this.known.history, text, merge)); }

  undo(): void {
    this.pending?.();
    const history = this.known.history;
    if (!history) return;
    // The last change may not be made yet: then it is not made at all.
    if (this.commits.pop()) return;
    if (!this.sent?.commit) return this.now(History.undo(history));
    this.sent.commit = false;
    this.ask({ text: history.text });
  }

  redo(): void {
    this.pending?.();
    if (this.known.history) this.now(History.redo(this.known.history));
  }

  save(): void {
    this.pending?.();
    const { history, file } = this.known;
    if (!history || file === null) return;
    clearTimeout(this.keeping);
    this.link?.say({ type: "save", file, text: history.text, mark: history.mark });
  }

  /** Which of two texts counts: that on disk, or the one here, which is saved over it. */
  settle(disk: boolean): void {
    const { notice, history } = this.known;
    if (notice?.kind !== "conflict" || !history) return;
    const known = History.withSavedText(history, notice.text, notice.mark);
    this.set({ notice: null });
    if (disk) {
      // Mine stays kept until there is another, or the file is left: undo brings it back till then.
      clearTimeout(this.keeping);
      [this.keeping, this.aside] = [undefined, true];
      this.shown(History.withEdit(known, notice.text));
    }
    else this.set({ history: known });
    if (!disk) this.save();
  }

  private keep(): void {
    clearTimeout(this.keeping);
    this.keeping = setTimeout(() => this.keepNow(), 300);
  }

  /** Whether a text of mine is kept that the file took the place of. */
  private aside = false;

  /** What is being kept, what is known to be, and whether that was refused. */
  private keptLast: string | null = null;
  private safe: string | null = null;
  private unkept = false;

  /** Whether edits would be lost with this page. */
  private losing(): boolean {
    this.pending?.();
    const { history, connection } = this.known;
    return (connection !== "open" || this.unkept) && history !== null && History.hasUnsavedEdits(history) && history.text !== this.safe;
  }

  private keepNow(): void {
    clearTimeout(this.keeping);
    this.keeping = undefined;
    this.aside = false;
    const { history, file } = this.known;
    if (!history || file === null) return;
    const { text, mark } = history;
    this.keptLast = text;
    this.link?.say(History.hasUnsavedEdits(history) ? { type: "keep", file, text, mark } : { type: "drop", file });
  }

  dismiss(): void { this.set({ notice: null }); }

  // ------------------------------------------------------------------ what is looked at

  pose(asked: PoseRequest): void {
    const { asked: was, history } = this.known;
    const since = performance.now();
    const shown = asked.travel_mm === undefined && asked.torque_Nm === undefined;
    const now = { asked: { line: was.line ?? 0, ...asked } };
    clearTimeout(this.resting);
    if (shown || !history) {
      // A state is here already; only its curves are asked for.
      this.set(now);
      painted(since);
    } else {
      // What a slider says is drawn with what follows it.
      this.known = { ...this.known, ...now };
      this.put({ kind: "pose", question: { text: history.text, pose: now.asked, want: [] }, commit: false, since });
    }
    this.resting = setTimeout(() => this.curves(), shown ? 0 : REST);
  }

  private resting: ReturnType<typeof setTimeout> | undefined;

  private curves(): void {
    const { history, asked, held } = this.known;
    if (history && held === null) this.put({ kind: "pose", question: { text: history.text, pose: asked }, commit: false, since: 0, shown: true });
  }

  /** Choose a cell; null takes the detail away, and the keyboard goes back to what opened it. */
  look(selected: SelectedCell | null): void {
    if (!selected) document.querySelector<HTMLElement>("[aria-controls=detail][aria-expanded=true]")?.focus();
    this.set({ selected });
    const row = selected && this.rows().find((r) => r.id === selected.row);
    // Where it is worst: in its state, and under the torque that winds the axle up there.
    if (row && selected) this.go(row, selected.state, ("spots" in row && row.spots?.[selected.state]?.[selected.part]) || {});
  }

  private go(row: { line: string }, state: number, spot: Partial<Spot> = {}): void {
    this.pose({ line: Math.max(this.known.live?.lines.findIndex((l) => l.name === row.line) ?? 0, 0), state, ...spot });
  }

  help(): void {
    const history = this.known.history;
    if (!history || this.known.helping) return;
    this.set({ helping: true });
    this.link?.say({ type: "help", id: this.latest, text: history.text });
  }

  speak(lang: string): void {
    writePreference("cardan-lang", lang);
    this.link?.say({ type: "hello", lang });
  }

  theme(theme: AppState["theme"]): void {
    writePreference("cardan-theme", theme);
    if (theme === "auto") delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = theme;
    this.set({ theme });
  }

  /** Every limit: what is known at once, and what came later, in one order. */
  rows(): (Row | (Limit & { values?: undefined }))[] {
    const { live, full, order } = this.known;
    if (!live) return [];
    const of = [live.limits, full?.limits ?? live.pending, order] as const;
    if (of.some((part, k) => part !== this.listed.of[k])) {
      const place = new Map(order.map((id, k) => [id, k]));
      const rows = [...of[0], ...of[1]].sort((a, b) => (place.get(a.id) ?? 1e6) - (place.get(b.id) ?? 1e6));
      this.listed = { of, rows };
    }
    return this.listed.rows;
  }

  private listed: { of: readonly unknown[]; rows: (Row | (Limit & { values?: undefined }))[] } = { of: [], rows: [] };

  /** The worst first; kept while a hand moves, so that nothing jumps under it. */
  private sorted(full: Full): string[] {
    const { live, order } = this.known;
    if (!live) return order;
    const rows = [...live.limits, ...full.limits];
    if (order.length === rows.length && rows.every((r) => order.includes(r.id))) return order;
    return rows.map((r) => ({ id: r.id, worst: worstRank(r) })).sort((a, b) => a.worst - b.worst).map((r) => r.id);
  }

  resort(): void {
    this.set({ order: [] });
    if (this.known.full) this.set({ order: this.sorted(this.known.full) });
  }
}

export const problemText = (p: Problem): string => [p.key, p.message].filter(Boolean).join(": ");

/** Why nobody answered, in words. */
const faulty = (of: string): string =>
  ({ cancelled: t("stopped"), "too slow": t("it took too long, and was stopped: request less, or run its command in a shell"), "too many": t("too many requests at once: wait, or stop something"), "is no longer there": t("The file is gone from the disk: Save writes it again."), ended: t("the process has ended: start it again"), "too much work": t("it has used half an hour of processor time, the most allowed: request less, or run its command in a shell"), MemoryError: t("it needs more memory than allowed: request less") })[of] ?? of;

const VARIANTS = 12;

/** What a grade weighs against margins. */
const GRADE = 1e6;

/** What a cell of a row is sorted by: failures first, then warnings, each by margin. */
const rank = (row: Row, s: number, p: number): number => (row.margins[s]?.[p] ?? 0) - GRADE * (row.grades[s]?.[p] ?? -Infinity);

const least = (of: number[]): number => of.reduce((best, v, k) => (v < (of[best] ?? Infinity) ? k : best), -1);

/** The part of a row that is worst in a state; -1 where none is asked about. */
export const worstPart = (row: Row, s: number): number => least((row.grades[s] ?? []).map((_, p) => rank(row, s, p)));

const worstIn = (row: Row): number[] => row.grades.map((_, s) => rank(row, s, worstPart(row, s)));

export const worstState = (row: Row): number => Math.max(0, least(worstIn(row)));

export const worstRank = (row: Row): number => Math.min(...worstIn(row));

/** A pose with what of the one before was not told again: its curves. */
function posed(was: Pose | null, now: Pose): Pose {
  const { at: _, stuck: __, ...kept } = was ?? now;
  return { ...kept, ...now };
}

/** Measure from a hand's move until what follows has been painted. */
function painted(since: number, what = "cardan:painted"): void {
  requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      if (performance.getEntriesByName(what).length > 500) performance.clearMeasures(what);
      performance.measure(what, { start: since, end: performance.now() });
    };
    port2.postMessage(0);
  });
}

export const store = new Store();
