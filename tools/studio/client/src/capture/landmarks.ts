// Points that are marked in photographs: what there is, and the way back.

export interface MarkedPhoto {
  number: number;
  name: string;
  time: string;
  place?: string;  ///< In which it is, if that is another one.
  path: string;
  image?: number;  ///< Of a movie.
  width: number;
  height: number;
}

/// Pixels of the photograph; pixel centers are whole numbers.
export interface Mark {
  photo: number;
  point: string;
  x: number;
  y: number;
}

/// What GET /api/landmarks says.
export interface LandmarksInfo {
  state: string;
  align: string;
  uses_marks: boolean;
  table: string | null;
  photos: MarkedPhoto[];
  marks: Mark[];
}

const kMostUndone = 200;
const kTenth = 10;  ///< A click is no more exact than a tenth of a pixel.

export class Landmarks {
  private marks: readonly Mark[];
  private saved: readonly Mark[];
  private readonly before: (readonly Mark[])[] = [];

  constructor(marks: Mark[]) {
    this.marks = this.saved = marks;
  }

  get all(): readonly Mark[] {
    return this.marks;
  }

  get is_changed(): boolean {
    return this.marks !== this.saved;
  }

  get can_undo(): boolean {
    return this.before.length > 0;
  }

  of_photo(photo: number): Mark[] {
    return this.marks.filter((m) => m.photo === photo);
  }

  at(photo: number, point: string): Mark | undefined {
    return this.marks.find((m) => m.photo === photo && m.point === point);
  }

  /// Names, as people count: 2 before 10.
  points(): string[] {
    return [...new Set(this.marks.map((m) => m.point))].sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
  }

  /// A number that no point has.
  new_point(): string {
    const used = new Set(this.marks.map((m) => m.point));
    let n = 1;
    while (used.has(String(n))) ++n;
    return String(n);
  }

  /// The first point of one photograph that another one lacks.
  first_missing(from: number, to: number): string | undefined {
    return this.points().find((p) => this.at(from, p) && !this.at(to, p));
  }

  /// From here on undo() comes back to. Once for a whole way of a marker that is dragged.
  begin(): void {
    this.before.push(this.marks);
    if (this.before.length > kMostUndone) this.before.shift();
  }

  /// Sets or moves a mark, inside of its photograph. @returns where it is.
  put(photo: MarkedPhoto, point: string, x: number, y: number): Mark {
    const inside = (v: number, size: number): number => Math.min(size - 0.5, Math.max(-0.5, Math.round(kTenth * v) / kTenth));
    const mark = { photo: photo.number, point, x: inside(x, photo.width), y: inside(y, photo.height) };
    this.marks = [...this.marks.filter((m) => m.photo !== photo.number || m.point !== point), mark];
    return mark;
  }

  replace(marks: Mark[]): void {
    this.marks = marks;
  }

  remove(photo: number, point: string): void {
    this.marks = this.marks.filter((m) => m.photo !== photo || m.point !== point);
  }

  remove_point(point: string): void {
    this.marks = this.marks.filter((m) => m.point !== point);
  }

  undo(): void {
    this.marks = this.before.pop() ?? this.marks;
  }

  /// What there is now lies on the disk.
  was_saved(): void {
    this.saved = this.marks;
  }
}
