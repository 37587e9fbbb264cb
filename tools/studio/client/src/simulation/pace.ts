// Running as fast as the server can, or a few iterations for every picture that this browser has shown: the paper's loop, and slow motion.
export interface PaceActions {
  run(): void;
  pause(): void;
  step(iterations: number): void;
}

const kPatience_ms = 200;  // A step that changes nothing brings no picture.

export class Pace {
  /// Iterations for a picture; 0: as fast as it can.
  iterations = 0;
  private is_on = false;
  private timer: number | undefined;

  constructor(private readonly actions: PaceActions) {}

  /// It runs in this browser's pace: the server itself pauses after every few iterations.
  get is_pacing(): boolean { return this.is_on; }

  start(): void {
    if (this.iterations === 0) this.actions.run();
    else {
      this.is_on = true;
      this.next();
    }
  }

  stop(): void {
    this.is_on = false;
    window.clearTimeout(this.timer);
    this.actions.pause();
  }

  /// A picture has come.
  picture(): void {
    if (this.is_on) this.next();
  }

  private next(): void {
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.picture(), kPatience_ms);
    this.actions.step(this.iterations);
  }
}
