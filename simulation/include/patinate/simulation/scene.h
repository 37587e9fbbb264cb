/// \file
/// What a simulation is made of, without files: objects, materials, emitters, rates. Lengths in mm, times in s unless
/// said, so that a reader of scene files (scene_io.h) converts once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "patinate/geometry/crease_normals.h"
#include "patinate/geometry/mesh.h"
#include "patinate/image/image.h"
#include "patinate/simulation/scene_map.h"
#include "patinate/simulation/weather.h"

namespace patinate::simulation {

inline constexpr int kMaxMaterials = 8;  ///< [Guenther et al. 2012, sec. 4.4].
inline constexpr std::size_t kMaxRules = 100;
inline constexpr double kMostAmount = 3.0;         ///< Largest amount that a surface may begin with.
inline constexpr std::size_t kMaxLayers = 8;       ///< Of an object, its substrate included.
inline constexpr double kMaxThicknessUm = 4000.0;  ///< Of a layer: 16 bits of quanta (LayerAtlas).
inline constexpr double kMaxStrength = 3.0;        ///< Of a layer that cracks: stress ends just under 4.

/// One value for each material of the scene; entries beyond Scene::materials are 0.
using MaterialValues = std::array<double, kMaxMaterials>;

/// A color, or a picture of the material that is laid over the surface, repeated.
struct ColorSource {
  Vec3 color{0.5, 0.5, 0.5};  ///< Linear RGB, [0, 1]; used where `image` is empty.
  ImageF image = {};          ///< H x W x 3, linear; may be empty.
  /// Width of the picture, mm: it is laid over objects from the sides that they face. 0: over the atlas, a pixel a
  /// texel.
  double image_mm = 0.0;
};

/// A material's color at one amount.
struct ColorStop {
  double amount = 0.0;                              ///< [0, kMostAmount].
  Vec3 color{0.5, 0.5, 0.5};                        ///< Linear RGB, [0, 1].
  std::optional<Vec3> second_color = std::nullopt;  ///< As MaterialAppearance::second_color; none: `color`.
};
inline constexpr std::size_t kMaxColorStops = 4;
inline constexpr double kMinColorStep = 0.01;  ///< Amounts between two stops.

/// How an amount of a material looks on a surface [Guenther et al. 2012, sec. 4.5]. A "strength" b and a "variation" v
/// weigh it by amount * b * (1 + v xi) with xi in [-1, 1) fixed per texel and material.
struct MaterialAppearance {
  ColorSource color;
  double strength = 1.0;            ///< >= 0: amount 1 covers the original color by this share.
  double variation = 0.0;           ///< [0, 1].
  double specular = 0.0;            ///< [-1, 1]: change of the specular value by amount 1.
  double specular_variation = 0.0;  ///< [0, 1].
  double height_mm = 0.0;           ///< Change of the height by amount 1.
  double height_variation = 0.0;    ///< [0, 1].
  /// Length of what varies, mm: xi is then noise in space, of an object's own size and without seams. 0 = each texel by
  /// itself.
  double grain_mm = 0.0;
  /// Linear RGB where xi is 1; `color` where it is -1, blended between. Only with a grain and without a picture.
  std::optional<Vec3> second_color = std::nullopt;
  /// The color follows the amount, amount * (1 + v xi), in place of `color` and `second_color`: linearly from stop to
  /// stop, and as the first and last before and behind them. Only without a picture. Empty, or 2 to kMaxColorStops
  /// with rising amounts. Amounts grow with time, so that it is the color by age too: the younger rust is the thinner
  /// one.
  std::vector<ColorStop> colors = {};
};

/// Material composition and look of a new object.
struct Preset {
  MaterialValues amounts{};  ///< [0, kMostAmount].
  ColorSource color;
  /// Linear RGB where `pattern`, the name of a map (SceneMap, built_in_maps()), is 1; `color` where it is 0. Without a
  /// pattern noise of the length `grain_mm` stands for it.
  std::optional<Vec3> second_color = std::nullopt;
  std::string pattern{};
  double grain_mm = 0.0;
  double specular = 0.3;   ///< [0, 1].
  double metalness = 0.0;  ///< [0, 1]: 1 where the color is that of bare metal. For pictures; nothing ages by it.
};

/// A direction along which a layer is under another tension than at right angles to it, as paint on wood is.
struct CrackTension {
  /// Unit, in the object's own coordinates; none: the longest side of each board (Board).
  std::optional<Vec3> along{};
  double ratio = 1.0;  ///< The tension along it, in parts of the stress, which is that across; [0.1, 10].
};

/// How a layer cracks under the stress that rules make (docs/algorithms/layer_cracks.md).
struct LayerCracks {
  /// Stress at which it cracks: an expression as Layer::thickness_um has it, cut to [0, kMaxStrength].
  std::string strength{"1"};
  double relief = 5.0;      ///< A crack relieves the stress beside it over so many thicknesses; [0.1, 1000].
  double shrinkage = 0.02;  ///< Strain that stress 1 stands for, by which cracks open; [0, 0.5].
  std::optional<CrackTension> tension{};  ///< None: alike in all directions.
  /// Where it is cracked at the start: where this expression is at least kCrackValue, along the center lines of what is
  /// so. Empty: nowhere. Pictures that it names are square.
  std::string initial{};
};
inline constexpr double kCrackValue = 0.5;

/// A coat of an object, or its substrate (docs/algorithms/layers.md).
struct Layer {
  std::string name;  ///< Letters, digits and _; of one object's layers unique.
  /// Its look where nothing lies above it. Its amounts are what it is made of: drivers see them, no contact takes them.
  Preset look{};
  /// Expressions of what SceneObject::initial may name, at the start: cut to [0, kMaxThicknessUm] and [0, 1]. Of the
  /// substrate they do not count.
  std::string thickness_um{};
  std::string adhesion{"1"};            ///< To the layer below.
  std::optional<LayerCracks> cracks{};  ///< None: it never cracks.
};

/// A mesh in the scene. Its UVs lie in the unit square (atlas_mesh.h).
struct SceneObject {
  std::string name;
  Mesh mesh;                 ///< mm, own coordinates.
  bool has_file_uvs = true;  ///< Its UVs are one square of those of its file: not unwrapped, not of several tiles.
  Preset preset;
  ImageF color_map;     ///< Linear RGB over the UVs in place of the preset's color; may be empty.
  ImageF specular_map;  ///< [0, 1]; may be empty.
  ImageF height_map;    ///< mm; may be empty.
  Vec3 translate_mm{0, 0, 0};
  Vec3 rotate_deg{0, 0, 0};  ///< About x, then y, then z of the world.
  double scale = 1.0;        ///< > 0.
  /// By material: an expression of maps (SceneMap, built_in_maps(), "slope") for the amount at the start, cut to [0,
  /// kMostAmount]; "" = the preset's. It shows, where the preset's is what the surface is made of.
  std::array<std::string, kMaxMaterials> initial{};
  /// > 0: texels along a mm of its surface, in the mean, where it stands at the start. None: what those that ask leave
  /// is shared by the others in proportion to their surfaces.
  std::optional<double> texels_per_mm{};
  double crease_deg = kCreaseDeg;  ///< Of a mesh without normals: edges that bend by more are hard; [0, 180].
  /// From the substrate outward, at most kMaxLayers. Empty: it is of its preset alone. Else the preset has the
  /// substrate's look, and no amounts.
  std::vector<Layer> layers{};
};

enum class EmitterShape {
  Point,      ///< All from `position`, within `spread` of `direction`.
  Disk,       ///< Uniform over a disk of diameter size[0] at right angles to the direction.
  Rectangle,  ///< Uniform over size[0] x size[1]; the first side is as near to world x as the direction allows.
  Sphere,     ///< Uniform over a sphere of diameter size[0], outward.
  Sky,  ///< From all over the scene's upper side, in directions within `spread` of `direction`, so that every place is
        ///< rained on alike.
  Surface  ///< The artist's brush: a disk that sits `distance` above the point of the surface nearest to `position`,
           ///< looking down its normal.
};
inline constexpr std::array<std::string_view, 6> kEmitterShapeNames{"point",  "disk", "rectangle",
                                                                    "sphere", "sky",  "surface"};

/// A source of gammatons. `gammatons` of them are under way at any time: one that ends is born again.
struct Emitter {
  std::string name;
  EmitterShape shape = EmitterShape::Rectangle;
  Vec3 position_mm{0, 0, 0};
  Vec3 direction{0, -1, 0};             ///< Unit.
  std::array<double, 2> size_mm{0, 0};  ///< >= 0.
  double spread_deg = 0.0;              ///< Half angle of a cone, uniform in solid angle; [0, 180].
  double speed_mm_s = 1000.0;           ///< > 0.
  double distance_mm = 10.0;            ///< Surface only.
  std::int64_t gammatons = 1000;        ///< [1, 10^7].
  MaterialValues carries{};             ///< [0, 16]: amounts at birth.
  bool is_on = true;                    ///< Off: its gammatons are not born again.
  /// Signal that sets the share of gammatons that is emitted: the weather's value over `full_at`, at most 1. The wind
  /// tilts every sky that follows a signal.
  std::optional<WeatherSignal> follows{};  ///< Not the temperature.
  double full_at = 0.0;                    ///< In the signal's unit; 0 = the greatest of the whole weather.

  // What the weather makes of it now; Simulation sets both before each iteration.
  double born_share = 1.0;  ///< [0, 1].
  Vec3 wind_mm_s{0, 0, 0};  ///< Comes to the velocity of birth of a sky.
};

/// What a gammaton does at a hit: Russian roulette between three responses [Guenther et al. 2012, sec. 4.1].
struct Behavior {
  double bounce = 0.2;  ///< Probabilities, >= 0; they and absorb sum to 1.
  double floating = 0.7;
  double absorb = 0.1;
  double deceleration_bounce = 0.4;  ///< Share of the speed that is lost, [0, 1].
  double deceleration_float = 0.3;
};

/// Figure 10's one slider, s in [0, 1]: in [0, 1/3] all bounce and lose ever more speed, up to nine tenths; in [1/3,
/// 2/3] from bouncing to floating; in [2/3, 1] all float and lose ever more speed, up to all. `absorb` is kept at
/// `absorb`.
[[nodiscard]] Behavior behavior_of_slider(double s, double absorb = 0.1);

/// The normal about which bounces are reflected.
enum class BounceNormal {
  Mesh,     ///< The mesh's shading normal: no look changes where gammatons go. The default.
  Composed  ///< The normal of the composed heights, as published: looks change results, and each iteration composes.
};
inline constexpr std::array<std::string_view, 2> kBounceNormalNames{"mesh", "composed"};

struct TracingOptions {
  double epsilon_mm = 0.5;  ///< A floating gammaton hovers by this; > 0.
  double pull = 0.5;        ///< Share of its speed that turns a floating drop toward the surface (the paper's h); >= 0.
  double reach_mm = 5.0;    ///< A floating gammaton looks this far along its way for the next contact; > 0.
  double lobe_exponent_bounce = 20;  ///< Phong lobes; >= 0.
  double lobe_exponent_float = 100;
  int max_segments = 6;             ///< Straight pieces in one iteration; [1, 64].
  bool tangential_slowdown = true;  ///< Floating keeps only the tangential part of the reflected speed.
  double rest_speed_mm_s = 10.0;    ///< Slower ones come to rest on ground that is nearly level.
  double rest_slope_deg = 30.0;     ///< Largest slope that counts as nearly level; [0, 90].
  BounceNormal bounce_normal = BounceNormal::Mesh;
  double wet_attraction = 0.0;  ///< How strongly a floating drop turns to where it is wetter; [0, 1], 0 = not at all.
  double rivulet_mm = 0.0;      ///< Width of the runs that form so; > 0 where drops are attracted.
  std::string wet_material = "water";  ///< Its amount is the wetness; no such material: none is wet.
};

/// Exchange of material at a hit [Guenther et al. 2012, sec. 4.2].
struct ExchangeOptions {
  double ratio = 0.5;      ///< r: 0 only picks up, 1 only drops.
  MaterialValues rates{};  ///< c_i, [0, 1]: per contact duration.
  double contact = 1.0;    ///< Duration of a contact; >= 0.
  int splat_texels = 1;    ///< Width of what one gammaton touches: 1, 3 or 5 texels of the median size.
  /// Width of a drop in mm in place of splat_texels; 0 = texels. What gammatons carry is then amounts over
  /// (splat_mm / 3)^2 mm2, whatever the atlas's resolution; else over a texel of the median size.
  double splat_mm = 0.0;
  bool deposit = true;  ///< Absorbed and resting gammatons leave their cargo where they end, as much as fits.
};

/// What a rule makes of a layer, or uses of it, by its extent.
struct LayerShares {
  MaterialValues at_interface{};  ///< Amounts between the layer and the one below it.
  double thickness_um = 0.0;      ///< Only used: no layer grows.
  double adhesion = 0.0;          ///< Only used.
  double stress = 0.0;            ///< Of layers that crack.

  [[nodiscard]] bool has_any() const;
  friend bool operator==(const LayerShares&, const LayerShares&) = default;
};

/// A reaction on the surface during the run. `driver` is an expression over materials ("min(water, metal)") and surface
/// parameters.
struct Rule {
  std::string name;
  std::string driver;
  double rate = 0.1;           ///< Per unit of the scene's time; >= 0.
  MaterialValues products{};   ///< Amount made per rate * driver * time.
  MaterialValues reactants{};  ///< Amount used up per the same; never more than there is.
  std::string where{};         ///< Expression of what a driver may name; its value, in [0, 1], is a factor. "" = 1.
  std::string layer{};         ///< The layer that it acts on, where that is; "" = the outermost one of each place.
  LayerShares layer_products{};
  LayerShares layer_reactants{};

  /// Such a rule acts only where its layer is.
  [[nodiscard]] bool changes_layers() const { return layer_products.has_any() || layer_reactants.has_any(); }
};

/// A change of a rule during the run; members without a value keep the rule's.
struct RuleChange {
  std::optional<std::string> driver;
  std::optional<double> rate;  ///< 0 = off.
  std::optional<MaterialValues> products;
  std::optional<MaterialValues> reactants;
  std::optional<LayerShares> layer_products{};
  std::optional<LayerShares> layer_reactants{};
  std::optional<std::string> where{};
  std::optional<Rule>
      begins;  ///< Comes to the scene's rules, after the others, if none has that name. What is given is in it.
};

/// A point where a brush paints, and for how long.
struct BrushStop {
  Vec3 position_mm{0, 0, 0};
  std::int64_t steps = 1;  ///< >= 1.
};

// The kinds of events. Names are those of the scene.

struct MoveEvent {
  std::string target;  ///< An emitter or an object; the emitter where both are called so.
  Vec3 position_mm{0, 0, 0};
};
struct TurnEvent {
  std::string object;
  Vec3 rotate_deg{0, 0, 0};  ///< As SceneObject::rotate_deg.
};
struct ScaleEvent {
  std::string object;
  double scale = 1.0;  ///< > 0.
};
/// The emitter of that name becomes this one, with as many gammatons as before.
struct EmitterEvent {
  Emitter emitter;
};
struct SwitchEvent {
  std::string emitter;
  bool is_on = true;
};
struct RatioEvent {
  double ratio = 0.5;  ///< As ExchangeOptions::ratio.
};
struct RateEvent {
  std::string material;
  double rate = 0.0;  ///< As ExchangeOptions::rates.
};
struct BehaviorEvent {
  Behavior behavior;
};
struct RuleEvent {
  std::string rule;
  RuleChange change;
};
/// Simulation::paint() at each stop, one after the other.
struct PaintEvent {
  std::string emitter;
  std::vector<BrushStop> stops;
};
using SceneAction = std::variant<MoveEvent, TurnEvent, ScaleEvent, EmitterEvent, RatioEvent, RateEvent, BehaviorEvent,
                                 SwitchEvent, RuleEvent, PaintEvent>;

/// An action of an artist during the run.
struct SceneEvent {
  std::int64_t iteration = 0;  ///< Before this one.
  SceneAction what;
};

/// The same again and again: before the iterations nearest to first + k every, k = 0, 1, ... below `count`.
struct EventSeries {
  double first = 0.0;                                             ///< In iterations, >= 0.
  double every = 1.0;                                             ///< In iterations, >= 1.
  std::int64_t count = std::numeric_limits<std::int64_t>::max();  ///< >= 1.
  SceneAction what;

  [[nodiscard]] bool is_due(std::int64_t iteration) const;
};

struct Scene {
  std::vector<std::string> materials;          ///< 1 to kMaxMaterials names, unique.
  std::vector<MaterialAppearance> appearance;  ///< As long as materials.
  std::vector<SceneObject> objects;            ///< At least one.
  std::vector<Emitter> emitters;
  Behavior behavior;
  TracingOptions tracing;
  ExchangeOptions exchange;
  std::vector<SceneMap> maps;  ///< Names differ from each other and from the materials.
  Weather weather;
  std::vector<Rule> rules;
  std::vector<SceneEvent> events;   ///< By iteration.
  std::vector<EventSeries> series;  ///< Those that are due at once come after the events, in this order.
  Vec3 gravity_mm_s2{0, -9810, 0};
  int resolution = 1024;  ///< Of the atlas; [16, 16384].
  std::uint64_t seed = 1;
  double time_per_iteration = 0.01;  ///< In the scene's unit of time: what one iteration stands for.
};

/// @throws InvalidInput naming the first value out of its range, material that is unknown, name that occurs twice; no
/// object; no emitter.
void check_scene(const Scene& scene);

/// Names of all layers above substrates, each once.
[[nodiscard]] std::vector<std::string> layer_names(const Scene& scene);
[[nodiscard]] bool has_layers(const Scene& scene);
[[nodiscard]] bool has_cracks(const Scene& scene);

/// What every parameter map may be called, for the given materials.
[[nodiscard]] std::vector<std::string> parameter_map_names(const std::vector<std::string>& materials);

}  // namespace patinate::simulation
