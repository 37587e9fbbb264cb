// A quiet line that offers to continue with what an earlier run of the program has left; gone when somebody has taken it.
import type { Recording } from "../types";
import { offer, settle, show_error } from "../ui/notices";
import { is_same_recording, recording_text } from "./recorded";

const kAbout = "recording";

export class ResumeOffer {
  private recording: Recording | null | undefined;
  private dismissed: Recording | undefined;

  /// @param go  Resumes. @param is_closed  Nobody is there any more to be told what went wrong.
  constructor(private readonly go: () => Promise<void>, private readonly is_closed: () => boolean) {}

  /// What the server says can be resumed.
  show(recording: Recording | null | undefined): void {
    this.recording = recording;
    if (!recording) settle(kAbout);
    if (!recording || is_same_recording(recording, this.dismissed)) return;
    offer("An earlier run of the program has left what was done here.", recording_text(recording), kAbout, () => void this.take(), () => { this.dismissed = recording; });
  }

  private async take(): Promise<void> {
    try {
      await this.go();
      settle("op resume");
    } catch (error) {
      if (this.is_closed()) return;
      show_error(error, "op resume");
      this.show(this.recording);  // It is still there.
    }
  }
}
