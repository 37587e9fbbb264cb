#include "transfer/synthesis/transfer_controls.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "libcommon/controls/control_expression.h"
#include "libcommon/core/text.h"
#include "patinate/controls/control_kinds.h"
#include "patinate/core/error.h"
#include "transfer/guidance/compared_control.h"

namespace patinate::transfer {

namespace {

/// Range of a map that says which history applies.
ControlRange index_range(const ControlMap& made, std::size_t num_parts) {
  const double low = std::min(made.low, made.high), high = std::max(made.low, made.high);
  if (made.unit == "relative" && !(low >= 0.0 && high <= 1.0)) return {low, high, kLibraryControlUnit};
  return {0.0, static_cast<double>(num_parts - 1), kLibraryControlUnit};
}

/// 0 outside the mask and beside the histories, else the index of the history and 1.
ImageU8 source_labels(const std::vector<LibraryPart>& parts, const ImageU8& mask) {
  ImageU8 labels(mask.width(), mask.height());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const LibraryPart& part = parts[p];
    for (int y = 0; y < part.height; ++y) {
      for (int x = part.x; x < part.x + part.width; ++x)
        labels.at(x, y) = mask.at(x, y) != 0 ? static_cast<std::uint8_t>(p + 1) : std::uint8_t{0};
    }
  }
  return labels;
}

/// 0 outside the charts, else the index of the nearest history and 1. @param share  The matched kLibraryControl.
ImageU8 destination_labels(const ImageF& share, const ImageU8& coverage, std::size_t num_parts) {
  ImageU8 labels(share.width(), share.height());
  for (std::size_t t = 0; t < labels.values().size(); ++t) {
    if (coverage.values()[t] == 0) continue;
    labels.values()[t] = static_cast<std::uint8_t>(
        1.0 + std::floor(static_cast<double>(share.values()[t]) * static_cast<double>(num_parts - 1) + 0.5));
  }
  return labels;
}

/// Histories that texels ask for.
std::vector<std::size_t> asked_histories(const History& history, const std::vector<LibraryPart>& parts,
                                         const ImageU8& destination, const ImageU8& source) {
  std::vector<std::size_t> asked;
  const auto has = [](const ImageU8& labels, std::size_t label) {
    return std::find(labels.values().begin(), labels.values().end(), static_cast<std::uint8_t>(label)) !=
           labels.values().end();
  };
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!has(destination, p + 1)) continue;
    asked.push_back(p);
    if (has(source, p + 1)) continue;
    throw InvalidInput(history.label() + ": no pixel of its history " + std::to_string(p) + " (" + parts[p].name +
                       ") is inside the mask, but --control " + kLibraryControl + " asks for it; give a larger mask");
  }
  return asked;
}

}  // namespace

TransferControl make_transfer_control(const History& history, const ControlSpec& spec, ControlMap made,
                                      const ImageU8& coverage) {
  const std::size_t num_parts = history.facts().parts.size();
  TransferControl control{source_control(history, spec),    spec.destination, {},
                          {made.low, made.high, made.unit}, spec.weight,      {}};
  if (spec.mapping) {
    control.mapping = *spec.mapping;
  } else if (control.source == kLibraryControl && num_parts > 0) {
    control.mapping = ControlMapping::Physical;
    control.range = index_range(made, num_parts);
  } else if (made.has_file) {
    control.mapping = suited_mapping(made.values, coverage).mapping;
  }
  control.values = std::move(made.values);
  return control;
}

std::vector<ControlSpec> parse_controls(std::span<const std::string> texts) {
  std::vector<ControlSpec> specs;
  for (const std::string& text : texts) {
    specs.push_back(parse_control_spec(text));
    (void)ControlExpression(specs.back().destination, control_kind_names());
  }
  return specs;
}

std::vector<ControlSpec> with_sources(const History& history, std::vector<ControlSpec> specs) {
  for (std::size_t i = 0; i < specs.size(); ++i) {
    specs[i].source = source_control(history, specs[i]);
    for (std::size_t k = 0; k < i; ++k) {
      if (specs[k].source == specs[i].source)
        throw ParseError("--control: `" + specs[i].source + "` is given twice; combine them in one expression");
    }
  }
  return specs;
}

std::vector<TransferControl> make_transfer_controls(
    const History& history, std::span<const ControlSpec> specs, const ImageU8& coverage,
    const std::function<ControlMap(std::size_t number, const ControlSpec& spec)>& make) {
  std::vector<TransferControl> controls;
  for (std::size_t i = 0; i < specs.size(); ++i)
    controls.push_back(make_transfer_control(history, specs[i], make(i, specs[i]), coverage));
  return controls;
}

ImageU8 usable_mask(const History& history, const ImageU8& given) {
  ImageU8 mask = history.read_mask();
  if (given.empty()) return mask;
  if (!given.same_size(mask)) {
    throw InvalidInput("source mask: is " + size_text(given.width(), given.height()) + " pixels; the history " +
                       history.label() + " is " + size_text(mask.width(), mask.height()));
  }
  bool is_empty = true;
  for (std::size_t i = 0; i < mask.values().size(); ++i) {
    mask.values()[i] = std::min(mask.values()[i], given.values()[i]);
    is_empty = is_empty && mask.values()[i] == 0;
  }
  if (is_empty) throw InvalidInput("source mask: leaves no pixel of the history's own mask; 0 = must not be copied");
  return mask;
}

MatchedControls match_controls(const History& history, const ImageU8& source_mask,
                               const std::vector<TransferControl>& controls, const ImageU8& coverage,
                               const RunControl& control) {
  MatchedControls out;
  for (const TransferControl& c : controls)
    out.source.push_back(compared_control(history, c.source, source_mask, control));
  out.destination.resize(controls.size());
  const auto range_of = [&](const TransferControl& c) -> ControlRange {
    const ControlFacts& parameter = history.control(c.source);
    return {parameter.low, parameter.high, parameter.unit};
  };
  const std::vector<LibraryPart>& parts = history.facts().parts;
  const auto says_history = [&](const TransferControl& c) { return !parts.empty() && c.source == kLibraryControl; };
  ImageU8 texels, pixels;  // Labels, where the controls say which history applies.
  for (std::size_t i = 0; i < controls.size(); ++i) {
    const TransferControl& c = controls[i];
    if (!says_history(c)) continue;
    out.destination[i] =
        match_control(c.values, coverage, c.range, out.source[i], source_mask, range_of(c), c.mapping, control);
    texels = destination_labels(out.destination[i], coverage, parts.size());
    pixels = source_labels(parts, source_mask);
    out.asked_histories = asked_histories(history, parts, texels, pixels);
  }
  for (std::size_t i = 0; i < controls.size(); ++i) {
    const TransferControl& c = controls[i];
    if (says_history(c)) continue;
    out.destination[i] =
        texels.empty()
            ? match_control(c.values, coverage, c.range, out.source[i], source_mask, range_of(c), c.mapping)
            : match_control_by_label(c.values, texels, c.range, out.source[i], pixels, range_of(c), c.mapping, control);
  }
  return out;
}

}  // namespace patinate::transfer
