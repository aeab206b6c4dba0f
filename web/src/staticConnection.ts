// In place of a server: answers that were computed beforehand, in a page of its own.

import type { ConnectionState } from "./socket";
import type { Full, Live, Pose, PoseRequest, ClientMessage, Spot, ServerMessage } from "./types";

interface Kept { welcome: Omit<Extract<ServerMessage, { type: "welcome" }>, "type">; live: Live; full: Full; lines: { states: Pose[]; travel: Pose[]; wound: (Spot & { state: number; pose: Pose })[] }[] }

export class StaticConnection {
  private readonly kept: Kept;

  constructor(text: string, private readonly told: (message: ServerMessage) => void, private readonly state: (connection: ConnectionState) => void) {
    this.kept = JSON.parse(text) as Kept;
  }

  open(): void { this.state("open"); }

  say(m: ClientMessage & { pose?: PoseRequest }): void {
    const { welcome, live, full } = this.kept;
    const id = m.id ?? 0;
    if (m.type === "hello") this.told({ type: "welcome", ...welcome });
    if (m.type === "open") this.told({ type: "opened", file: 0, name: welcome.files[0] ?? "", saved: "", mark: "", draft: null, stale: false, base: "", elsewhere: false, left: 0, variants: [], revisions: [] });
    if (m.type === "ask") this.told({ type: "live", id, text: "", ...live, pose: this.pose({ line: 0, state: live.worst }) });
    if (m.type === "ask") this.told({ type: "full", id, text: "", ...full });
    if (m.type === "pose") this.told({ type: "posed", id, text: "", pose: this.pose(m.pose ?? {}) });
  }

  /** The pose that is nearest; its curves are those of the worst state. */
  private pose({ line = 0, state, travel_mm, torque_Nm, way }: PoseRequest): Pose {
    const of = this.kept.lines[line] ?? { states: [], travel: [], wound: [] };
    const still = of.states[state ?? this.kept.live.worst] as Pose;
    const wound = of.wound.find((w) => w.state === state && w.torque_Nm === torque_Nm && w.way === way);
    if (travel_mm === undefined && !wound) return still;
    const away = (p: Pose): number => Math.abs(p.travel - (travel_mm ?? 0));
    const near = wound?.pose ?? of.travel.reduce((a, b) => (away(b) < away(a) ? b : a), of.travel[0] as Pose);
    const { over_travel, turn } = still;
    return { ...near, ...(over_travel ? { over_travel } : {}), ...(turn ? { turn } : {}) };
  }
}
