#include "capture/unlighting/unlit_document.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/unlighting/unlight_report.h"
#include "libcommon/document/document.h"

namespace patinate::capture {

namespace {

struct MapInfo {
  std::string_view name, help;
  bool is_always_there;
};
constexpr std::array<MapInfo, 7> kMaps{{{"albedo", "", true},
                                        {"stddev", "", true},
                                        {"normal", "", true},
                                        {"mask", "", true},
                                        {"specular", "With a search for highlights.", false},
                                        {"reflectance", "F0 by channel; with `--specular material`.", false},
                                        {"metalness", "[0, 1]; with `--specular material`.", false}}};
constexpr std::array<std::string_view, 2> kAboutNames{"middle", "mirror"};
constexpr std::array<std::string_view, 2> kTintNames{"white", "base"};

constexpr DocumentKind kUnlitDocument{.format = "patinate.unlit",
                                      .version = 2,
                                      .title = "patinate unlit step",
                                      .about = "unlight.json of a folder that `patinate unlight` made."};

void describe_color(DocumentVisitor& v, const Member& m, Vec3& color) {
  std::array<double, 3> channels{color.x(), color.y(), color.z()};
  v.member(m, channels);
  color = Vec3(channels[0], channels[1], channels[2]);
}

void describe_maps(DocumentVisitor& v, std::vector<UnlitMap>& maps) {
  for (const MapInfo& known : kMaps) {
    const auto found = std::find_if(maps.begin(), maps.end(), [&](const UnlitMap& m) { return m.name == known.name; });
    std::optional<std::filesystem::path> file;
    if (found != maps.end()) file = found->file;
    v.member({.name = known.name,
              .help = known.help,
              .presence = known.is_always_there ? Presence::Required : Presence::IfSet},
             file);
    if (v.is_reading() && file) maps.push_back({std::string(known.name), *file});
  }
}

}  // namespace

void describe(DocumentVisitor& v, SurfaceMaterial& m) {
  v.choice({"kind", "A white lobe, a tinted one without albedo, or a tinted one beside an albedo."}, m.kind,
           kMaterialKindNames);
  v.member({"share", "Of the texels that were asked.", between(0, 1)}, m.share);
  v.member({"roughness", "", between(0, 1)}, m.roughness);
  describe_color(v, {"strength", "Of the GGX lobe by channel, with single scattering.", at_least(0)}, m.strength);
  v.member({"evidence",
            "By how many standard deviations left-out lamps are predicted better as (or as not) metal; of what is "
            "matt, than with a lobe."},
           m.evidence);
}

void describe(DocumentVisitor& v, InterreflectionReport& r) {
  v.member({"median", "Share of what a texel's clean samples show, over texels.", at_least(0)}, r.median);
  v.member({"p95", "The share that one texel in twenty has more of.", at_least(0)}, r.p95);
  v.member(
      {"unseen", "Of the rays that met the scan, those that met it where the camera does not see it.", between(0, 1)},
      r.unseen);
}

void describe(DocumentVisitor& v, UnlitLobe& lobe) {
  v.member({.name = "tail",
            .help = "Exponent of Student's t distribution of slopes: 2 is GGX; null has no tail, Beckmann.",
            .is_nullable = true},
           lobe.tail);
  v.member({"slant", "Power of the lamp's cosine; that of the camera's is one less."}, lobe.slant);
  auto about = static_cast<int>(lobe.is_about_mirror);
  v.choice({"about"}, about, kAboutNames);
  lobe.is_about_mirror = about == 1;
  v.choice({"tint"}, lobe.tint, kTintNames);
}

void describe(DocumentVisitor& v, UnlitLight& light) {
  v.member({"name"}, light.name);
  v.object({"samples", "Pixels of the mask by what became of them."}, true, [&] {
    for (std::size_t s = 1; s < kNumSampleStates; ++s) {
      const std::string name = sample_state_name(static_cast<SampleState>(s));
      v.member({.name = name, .range = at_least(0)}, light.report.samples[s]);
    }
  });
  describe_color(v, {"strength"}, light.report.strength);
  v.member({"residual", "", at_least(0)}, light.report.residual);
  v.object({"leave_one_out", "Prediction from the other lamps."}, true, [&] {
    v.member({"rms", "", at_least(0)}, light.leave_one_out.rms);
    v.member({"median", "", at_least(0)}, light.leave_one_out.median);
    v.member({"samples", "", at_least(0)}, light.leave_one_out.num_samples);
  });
}

void describe(DocumentVisitor& v, UnlitDocument& d) {
  v.member({"name", "Of the step.", {}, Presence::Optional}, d.name);
  v.member({"width", "", between(1, 65536)}, d.width);
  v.member({"height", "", between(1, 65536)}, d.height);
  v.member({"channels", "1 = gray photographs.", between(1, 3)}, d.channels);
  v.object({"maps", "Files beside this one."}, true, [&] { describe_maps(v, d.maps); });
  v.member({"materials", "With `--specular material`: lobes that many texels share.", {}, Presence::IfSet},
           d.materials);
  v.member({"surface_pixels", "Inside the mask and seen on the scan.", at_least(0)}, d.num_surface);
  v.member({"determined_pixels", "Those with an albedo.", at_least(0)}, d.num_determined);
  v.member({"residual", "Root mean square of what clean samples are off, over their mean.", at_least(0)}, d.residual);
  v.member({"noise_scale", "Residuals over what --noise-floor and --noise-share expect.", above(0), Presence::Optional},
           d.noise_scale);
  v.member({"is_absolute",
            "False when the lights' strengths were not known: albedo has a scale of its own.",
            {},
            Presence::Optional},
           d.is_absolute);
  v.member({"is_converged", "Of strengths and ambient light, when asked for.", {}, Presence::Optional}, d.is_converged);
  describe_color(v, {"ambient", "Irradiance from everywhere, as found; else 0.", {}, Presence::Optional}, d.ambient);
  v.member({"interreflection",
            "Only with --interreflection: light that came from other places of the surface and was removed.",
            {},
            Presence::IfSet},
           d.interreflection);
  v.member({.name = "lobe",
            .help = "Form of the highlights: ggx, beckmann or student; null when none were looked for.",
            .presence = Presence::Optional,
            .is_nullable = true},
           d.lobe);
  v.member({.name = "lobe_form",
            .help = "What predicted left-out lamps best; null when no highlights were looked for.",
            .presence = Presence::Optional,
            .is_nullable = true},
           d.lobe_form);
  v.member({"lights", "In the photographs' order."}, d.lights);
  v.member({"notes", "What the user should know."}, d.notes);
  v.member({"key", "Content key of everything that this was made from."}, d.key);
}

UnlitDocument read_unlit(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path file = std::filesystem::is_directory(path, error) ? path / kUnlitManifestFile : path;
  Json root = load_json(file);
  update_spelling(root, 1, {{"left_out", "leave_one_out"}});
  UnlitDocument document;
  read_document(kUnlitDocument, file, root, described(document));
  for (UnlitMap& map : document.maps) map.file = file.parent_path() / map.file;
  return document;
}

Json unlit_json(const UnlitDocument& document) {
  UnlitDocument written = document;
  return document_json(kUnlitDocument, described(written));
}

Json unlit_schema() { return document_schema(kUnlitDocument, described<UnlitDocument>()); }

}  // namespace patinate::capture
