# cmake -Dsymbol=NAME -Dfile=FILE -Dsource=CPP -P embed_built.cmake: what patinate_embed_built() runs.
file(READ "${file}" text)
file(CONFIGURE OUTPUT "${source}" @ONLY CONTENT [=[
#include <string_view>
#pragma GCC diagnostic ignored "-Woverlength-strings"
namespace patinate {
extern const std::string_view @symbol@;
const std::string_view @symbol@ = R"embedded(@text@)embedded";
}  // namespace patinate
]=])
