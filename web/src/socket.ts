// The socket: opens, speaks, comes back after a loss. The token came behind the address's #.

import type { ClientMessage, ServerMessage } from "./types";

export type ConnectionState = "opening" | "open" | "lost" | "refused";

const KEY = "cardan-token";

/** The token of the address, kept for a reload of this tab alone and taken out of the address. */
export function sessionToken(): string {
  const given = location.hash.slice(1);
  if (given) {
    sessionStorage.setItem(KEY, given);
    history.replaceState(null, "", location.pathname);
  }
  return given || (sessionStorage.getItem(KEY) ?? "");
}

export class SocketConnection {
  private socket: WebSocket | null = null;
  private tries = 0;
  private longest = Infinity;

  constructor(private token: string, private readonly told: (message: ServerMessage) => void, private readonly state: (connection: ConnectionState) => void) {}

  open(): void {
    if (!this.token) {
      this.state("refused");
      return;
    }
    this.state("opening");
    let greeted = false;
    const socket = new WebSocket(`ws://${location.host}/ask`, ["cardan.1", this.token]);
    this.socket = socket;
    socket.onopen = () => {
      greeted = true;
      this.tries = 0;
      this.state("open");
    };
    socket.onmessage = (event) => {
      const told = JSON.parse(String(event.data)) as ServerMessage;
      // A code that let this page in does so once.
      if (told.type === "welcome") {
        sessionStorage.setItem(KEY, (this.token = told.token));
        this.longest = told.longest;
      }
      this.told(told);
    };
    socket.onclose = () => {
      this.tries += 1;
      // Never let in: another token, or nobody there any more.
      const refused = !greeted && this.tries > 4;
      this.state(refused ? "refused" : "lost");
      if (!refused) setTimeout(() => this.open(), Math.min(300 * 2 ** this.tries, 4000));
    };
  }

  /** What is longer than any message that is read is refused by what it is: all of it would end the socket. */
  say(message: ClientMessage): void {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const data = JSON.stringify(message);
    const bytes = 3 * data.length > this.longest ? new Blob([data]).size : 0;
    const { type, id, job, file, held } = message;
    this.socket.send(bytes > this.longest ? JSON.stringify({ type, id, job, file, held, bytes }) : data);
  }
}
