// A running scene: commands as promises, updates with credits, and coming back after the connection was lost.
import { get_places, StudioError, url_of } from "./api";
import type { Exported, Outcome, Probe, SceneState, Status, TilesHeader } from "./types";

export type Connection = "connecting" | "open" | "lost";

export interface LiveEvents {
  hello(scene: SceneState): void;
  scene(change: Partial<SceneState>): void;
  status(status: Status): void;
  /// Tiles of one plane; `payload` begins with the numbers. The view calls acknowledge() when the update with `last` is on screen.
  tiles(header: TilesHeader, payload: ArrayBuffer, offset: number): void;
  gammatons(positions: Float32Array): void;
  hash(hash: { iteration: number; surface: string; relief: string; material: string }): void;
  outcome(outcome: Outcome): void;
  probe(probe: Probe): void;
  exported(exported: Exported): void;
  progress(text: string, done: number, total: number): void;
  notice(text: string): void;
  /// Something went wrong that no command waits for.
  problem(message: string): void;
  connection(state: Connection, why?: string): void;
  /// The server will not have it, or not any more: nothing comes after this.
  refused(why: string): void;
}

export interface Watch {
  planes: string[];
  overlay: string | null;
  gammatons: number;
}

/// What errors are about when the connection is lost.
export const kConnection = "connection";
const kFirstRetry_ms = 400, kLastRetry_ms = 5000;

/// Members of what the server answers to a command.
export type Answer = Record<string, unknown>;
type Waiting = { resolve: (answer: Answer) => void; reject: (error: Error) => void };

export class Live {
  watch: Watch = { planes: ["surface", "relief", "material"], overlay: null, gammatons: 0 };
  private socket: WebSocket | undefined;
  private readonly waiting = new Map<number, Waiting>();
  private next_id = 1;
  private retry_ms = kFirstRetry_ms;
  private timer: number | undefined;
  private is_closed = false;
  private has_hello = false;

  constructor(readonly place: string, private readonly events: LiveEvents) {
    this.connect();
  }

  get is_open(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /// One command. @throws StudioError what the server says, or that there is no connection.
  send(op: string, fields: Record<string, unknown> = {}): Promise<Answer> {
    if (this.is_closed) return Promise.reject(new StudioError("The scene does not run here any more; open it again.", kConnection));
    if (!this.is_open) return Promise.reject(new StudioError("There is no connection to the server; wait until it is back.", kConnection));
    const id = this.next_id++;
    const done = new Promise<Answer>((resolve, reject) => this.waiting.set(id, { resolve, reject }));
    this.socket?.send(JSON.stringify({ op, id, ...fields }));
    return done;
  }

  set_watch(change: Partial<Watch>): void {
    Object.assign(this.watch, change);
    if (this.is_open) void this.send("watch", { ...this.watch }).catch((error: Error) => { if (this.is_open) this.events.problem(error.message); });  // Who comes back says it again.
  }

  acknowledge(update: number): void {
    if (this.is_open) this.socket?.send(JSON.stringify({ op: "ack", update }));
  }

  close(): void {
    this.is_closed = true;
    window.clearTimeout(this.timer);
    this.fail_waiting("The view was closed.");
    this.socket?.close();
  }

  private connect(): void {
    this.events.connection("connecting");
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}${url_of("/api/live", { place: this.place })}`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.has_hello = false;
    socket.onopen = () => {
      this.retry_ms = kFirstRetry_ms;
      this.events.connection("open");
      this.set_watch({});
    };
    socket.onmessage = (message: MessageEvent<string | ArrayBuffer>) => {
      if (socket !== this.socket || this.is_closed) return;
      if (typeof message.data === "string") this.read_text(message.data);
      else this.read_binary(message.data);
    };
    socket.onclose = () => {
      if (socket !== this.socket || this.is_closed) return;
      this.fail_waiting("The connection was lost before the server answered.");
      void this.come_back();
    };
  }

  // A refused WebSocket says nothing; a request tells whether the server is away, or does not want this browser.
  private async come_back(): Promise<void> {
    const why = await get_places().then(() => undefined, (error: Error) => error.message);
    if (this.is_closed) return;
    this.events.connection("lost", why);
    this.timer = window.setTimeout(() => this.connect(), this.retry_ms);
    this.retry_ms = Math.min(2 * this.retry_ms, kLastRetry_ms);
  }

  // No one tries again: what cannot be read stays so.
  private end(why: string): void {
    this.close();
    this.events.refused(why);
  }

  private fail_waiting(message: string): void {
    for (const { reject } of this.waiting.values()) reject(new StudioError(message, kConnection));
    this.waiting.clear();
  }

  private read_text(text: string): void {
    const message = JSON.parse(text) as Record<string, unknown> & { type: string };
    switch (message.type) {
      case "done":
      case "error": {
        const waiting = this.waiting.get(message["id"] as number);
        this.waiting.delete(message["id"] as number);
        if (message.type === "done") waiting?.resolve(message);
        else if (waiting) waiting.reject(new StudioError(String(message["message"])));
        else if (message["fatal"] === true || !this.has_hello) this.end(String(message["message"]));
        else this.events.problem(String(message["message"]));
        break;
      }
      case "hello":
        this.has_hello = true;
        this.events.hello(message as unknown as SceneState);
        break;
      case "scene": this.events.scene(message as unknown as Partial<SceneState>); break;
      case "status": this.events.status(message as unknown as Status); break;
      case "hash": this.events.hash(message as unknown as Parameters<LiveEvents["hash"]>[0]); break;
      case "outcome": this.events.outcome(message as unknown as Outcome); break;
      case "probe": this.events.probe(message as unknown as Probe); break;
      case "exported": this.events.exported(message as unknown as Exported); break;
      case "progress": this.events.progress(String(message["text"]), Number(message["done"]), Number(message["total"])); break;
      case "notice": this.events.notice(String(message["text"])); break;
    }
  }

  private read_binary(data: ArrayBuffer): void {
    const header_bytes = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, header_bytes))) as TilesHeader | { type: "gammatons"; count: number };
    const offset = 4 + header_bytes;
    if (header.type === "tiles") this.events.tiles(header, data, offset);
    else if (header.type === "gammatons") this.events.gammatons(new Float32Array(data, offset, 3 * header.count));
  }
}
