// Textures at times: one request at a time, the newest wish wins, what was seen lately is kept.
import { get_texture, type Texture, type TextureQuery } from "../api";

const kKeptBytes = 160 * 1024 * 1024;

export class FrameLoader {
  between = "blend";
  private readonly kept = new Map<string, Texture>();
  private kept_bytes = 0;
  private wanted: number | undefined;
  private is_busy = false;
  private readonly stop = new AbortController();
  private idle: (() => void)[] = [];

  constructor(private readonly query: Omit<TextureQuery, "time" | "between">, private readonly show: (texture: Texture, time: number) => void, private readonly fail: (error: unknown) => void) {}

  request(time: number): void {
    this.wanted = time;
    if (!this.is_busy) void this.work();
  }

  /// When all wishes have been fulfilled.
  settled(): Promise<void> {
    return this.is_busy ? new Promise((resolve) => this.idle.push(resolve)) : Promise.resolve();
  }

  dispose(): void {
    this.stop.abort();
    this.kept.clear();
  }

  private async work(): Promise<void> {
    this.is_busy = true;
    while (this.wanted !== undefined && !this.stop.signal.aborted) {
      const time = this.wanted;
      this.wanted = undefined;
      try {
        this.show(await this.load(time), time);
      } catch (error) {
        this.fail(error);
      }
    }
    this.is_busy = false;
    for (const resolve of this.idle.splice(0)) resolve();
  }

  private async load(time: number): Promise<Texture> {
    const key = `${time} ${this.between}`;
    const found = this.kept.get(key);
    if (found) {
      this.kept.delete(key);
      this.kept.set(key, found);
      return found;
    }
    const texture = await get_texture({ ...this.query, time, between: this.between }, this.stop.signal);
    this.kept.set(key, texture);
    this.kept_bytes += texture.bytes.length;
    for (const [oldest, { bytes }] of this.kept) {
      if (this.kept_bytes <= kKeptBytes) break;
      this.kept.delete(oldest);
      this.kept_bytes -= bytes.length;
    }
    return texture;
  }
}
