/// \file
/// The parts of a comparison: what is said about two surfaces, from their colors alone.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/figures/compared_pair.h"
#include "patinate/analysis/report_parts.h"

namespace patinate::analysis {

/// How the two look over time, at up to six of the compared times.
[[nodiscard]] Section look_section(const ComparedPair& pair);
/// Place by place: CIEDE2000, SSIM and absolute error, the common clock, every texel's delay. Undefined when places do
/// not correspond.
[[nodiscard]] Section places_section(const ComparedPair& pair, const CompareOptions& options,
                                     const RunControl& control = {});
/// The first figures of it alone: CIEDE2000, SSIM and absolute error over places and times; none when places do not
/// correspond.
[[nodiscard]] std::vector<Figure> difference_figures(const ComparedPair& pair, const RunControl& control = {});
/// Whatever needs no correspondence: distribution of colors, onset, saturation, covered share.
[[nodiscard]] Section colors_section(const ComparedPair& pair, const CompareOptions& options,
                                     const RunControl& control = {});
/// Structure: radial power spectrum, correlation length.
[[nodiscard]] Section structure_section(const ComparedPair& pair, const CompareOptions& options,
                                        const RunControl& control = {});
/// Color and rate of change by control; a section that says why when there is no common control.
[[nodiscard]] Section controls_section(const ComparedPair& pair, const CompareOptions& options,
                                       const RunControl& control = {});

/// Compares the materials of the two beside their color: roughness, metalness, reflectance and height over time, and
/// how far their BRDFs are apart. Says something only where a side states a material (states_material()).
[[nodiscard]] Section materials_section(const ComparedPair& pair, const CompareOptions& options,
                                        const RunControl& control = {});

/// Dark lines at the last common time: their share, width, cells and the angles at which they meet.
[[nodiscard]] Section cracks_section(const ComparedPair& pair, const CompareOptions& options,
                                     const RunControl& control = {});

/// A section and how it is made.
struct NamedSection {
  std::string name;
  std::function<Section(const ComparedPair&, const CompareOptions&, const RunControl&)> make;
};
/// Those of a comparison, in the order of its report; materials where a side states them.
[[nodiscard]] std::vector<NamedSection> compared_sections(const CompareOptions& options, const HistoryFacts& a,
                                                          const HistoryFacts& b);

/// Sections share these.

/// A figure of two surfaces by their blocks, and what surrounds it: interval, and A against itself split in two.
struct SplitFigure {
  std::vector<double> value;  ///< Empty when undefined.
  std::optional<std::vector<FigureInterval>> intervals;
  std::vector<double> split;  ///< Empty when undefined.
};
/// @param a_b  The figure of A and B. @param a_a  The same of A and A.
[[nodiscard]] SplitFigure split_figure(const ComparedPair& pair, const BlockFigure& a_b, const BlockFigure& a_a,
                                       const CompareOptions& options, std::uint32_t purpose, const RunControl& control);
/// Component `k` of it, with its interval, not below 0. @param undefined  Said when there is no value.
[[nodiscard]] Figure figure_of(const SplitFigure& f, std::size_t k, const std::string& name, const std::string& title,
                               const std::string& unit, const std::string& undefined);
/// Pictures at some of the compared times side by side, no larger than a page shows them.
[[nodiscard]] Picture picture_strip(const std::string& name, const std::string& caption, const ComparedPair& pair,
                                    const std::vector<std::size_t>& times,
                                    const std::function<ImageF(std::size_t time)>& image);
inline constexpr std::size_t kPicturesInARow = 5;
/// At most `most` indices of `count`, evenly, the first and the last among them.
[[nodiscard]] std::vector<std::size_t> spread_indices(std::size_t count, std::size_t most);

}  // namespace patinate::analysis
