// What the run has done to each object since its start: whether its rates are right.
import type { Outcome, Status } from "../types";
import { button, number_text, section } from "../ui/controls";
import { h, replace } from "../ui/dom";

const percent = (share: number): string => (share > 0 && share < 5e-4 ? "< 0.1 %" : `${number_text(Math.round(1000 * share) / 10)} %`);

const state_of = (status: Status): string => JSON.stringify([status.iteration, status.ledger]);

const kColumns: [string, string][] = [["", ""], ["mean", "Amount; 1 = a full layer"], ["most", "Largest amount"], ["shows", "Share of the surface where it covers a tenth of the color or more"],
  ["hides", "Share where it covers all of the color: more makes no difference"], ["full", "Share where a texel holds no more"]];

export class OutcomePanel {
  readonly element: HTMLDetailsElement;
  private readonly body = h("div", { class: "stack" });
  private status: Status | undefined;
  /// What was asked for, and shown, last: strokes and undo change masses and not the iteration.
  private shown = "";
  private asked = "";

  /// @param ask  Sends `outcome`.
  constructor(private readonly ask: () => void) {
    this.element = section("What it has done", false, this.body, button("Look again", () => this.request(), { hint: "While it runs; when it pauses this is done by itself" }));
    this.element.addEventListener("toggle", () => this.follow());
  }

  show_status(status: Status): void {
    this.status = status;
    this.follow();
  }

  show(outcome: Outcome): void {
    this.shown = this.asked;
    this.asked = "";
    replace(this.body, h("p", { class: "hint" }, `After ${number_text(outcome.iteration, 7)} iterations, since the start.`),
      outcome.advice.map((text) => h("p", { class: "advice", role: "status" }, text)),
      Object.entries(outcome.objects).map(([name, object]) => {
        const rows = Object.entries(object.materials).filter(([, m]) => m.largest > 0);
        const met = object.never_met_share === undefined ? "" : `; no gammaton met ${percent(object.never_met_share)} of it`;
        return h("div", { class: "outcome" }, h("h3", {}, name),
          h("p", {}, `Changed by ${number_text(object.change_mean)} ΔE in the mean, 95 % of it by less than ${number_text(object.change_p95)}${met}.`),
          h("div", { class: "ledger-box", tabindex: 0, role: "region", "aria-label": `Materials on ${name}` },
            h("table", { class: "ledger" }, h("thead", {}, h("tr", {}, kColumns.map(([text, hint]) => h("th", { scope: "col", title: hint }, text)))),
              h("tbody", {}, rows.map(([material, m]) => h("tr", {}, h("th", { scope: "row" }, material),
                [number_text(m.mean), number_text(m.largest), percent(m.shows_share), percent(m.hides_share), percent(m.full_share)].map((text) => h("td", {}, text))))))));
      }));
  }

  /// Figures are of other looks, or of another connection.
  forget(): void {
    this.asked = "";
    this.shown = "";
    this.follow();
  }

  // When it is opened, and when the run has come to rest.
  private follow(): void {
    const { status } = this;
    if (!this.element.open || !status || status.painting) return;
    const state = state_of(status);
    if (state === this.shown || state === this.asked) return;
    if (status.running && this.shown !== "") return;
    this.request();
  }

  private request(): void {
    this.asked = this.status ? state_of(this.status) : "";
    this.ask();
  }
}
