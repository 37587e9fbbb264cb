#include "libcommon/core/module.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "libcommon/core/files.h"
#include "libcommon/image/image_source.h"
#include "libcommon/image/media_module.h"
#include "patinate/core/error.h"
#include "tests/support/temp_folder.h"

namespace patinate {
namespace {

using testing_support::TempFolder;

template <class Kind, class Work>
std::string problem_of(const Work& work) {
  try {
    work();
  } catch (const Kind& e) {
    EXPECT_EQ(typeid(e), typeid(Kind));
    return e.what();
  }
  ADD_FAILURE() << "nothing of this type was thrown";
  return "";
}

/// $PATINATE_MODULES while it lives.
class ModuleFolder {
 public:
  explicit ModuleFolder(const std::filesystem::path& folder) { ::setenv("PATINATE_MODULES", folder.c_str(), 1); }
  ~ModuleFolder() { ::unsetenv("PATINATE_MODULES"); }
  ModuleFolder(const ModuleFolder&) = delete;
  ModuleFolder& operator=(const ModuleFolder&) = delete;
};

TEST(Module, AMissingOneIsNamedOnOneLine) {
  const TempFolder folder;
  const ModuleFolder given(folder.path());
  const std::string problem =
      problem_of<CannotComplete>([] { (void)module_function("patinate-nothing", "patinate_nothing_1"); });
  EXPECT_TRUE(problem.starts_with((folder / "patinate-nothing.so").string() + ": cannot be loaded (")) << problem;
  EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
}

TEST(Module, AFileThatIsNoLibraryIsNamedOnOneLine) {
  const TempFolder folder;
  const ModuleFolder given(folder.path());
  write_atomically(folder / "patinate-text.so", "no library at all\n");
  const std::string problem =
      problem_of<CannotComplete>([] { (void)module_function("patinate-text", "patinate_text_1"); });
  EXPECT_TRUE(problem.starts_with((folder / "patinate-text.so").string() + ": cannot be loaded (")) << problem;
  EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
}

TEST(Module, OneOfAnotherVersionIsRefused) {
  const std::string problem =
      problem_of<CannotComplete>([] { (void)module_function("patinate-media", "patinate_media_0"); });
  EXPECT_NE(problem.find("patinate-media.so: is of another version than this program"), std::string::npos) << problem;
}

TEST(Module, AFunctionIsFoundAgain) {
  void* function = module_function("patinate-media", kMediaEntry);
  EXPECT_NE(function, nullptr);
  EXPECT_EQ(module_function("patinate-media", kMediaEntry), function);
}

// The module has types of its own of the same names; whoever catches ours must catch those.
TEST(Module, ItsErrorsAreCaughtByTheirTypes) {
  const TempFolder folder;
  write_atomically(folder / "no.tif", "no TIFF");
  const std::string unread =
      problem_of<IoError>([&] { (void)media_module().open_image(folder / "no.tif", folder / "no.tif", false); });
  EXPECT_TRUE(unread.starts_with((folder / "no.tif").string() + ": is no readable image")) << unread;
  EXPECT_THROW((void)media_module().open_image(folder / "no.tif", folder / "no.tif", false), Error);  // Its base.

  MemorySink sink;
  const EncodedFormat unknown{.name = "a.unknown", .width = 1, .height = 1, .channels = {"Y"}};
  EXPECT_NE(problem_of<ParseError>([&] { (void)media_module().create_encoder(unknown, sink); }).find("a.unknown: "),
            std::string::npos);

  const auto gif = media_module().create_gif("a.gif", 10.0, sink);
  gif->add(ImageU8(4, 4, 3));
  EXPECT_NE(problem_of<InvalidInput>([&] { gif->add(ImageU8(5, 4, 3)); }).find("differs from the first in size"),
            std::string::npos);

  const MovieFormat nowhere{.path = folder / "nowhere" / "a.mp4",
                            .shown_path = "a.mp4",
                            .extension = ".mp4",
                            .width = 16,
                            .height = 16,
                            .fps = 10.0,
                            .comment = ""};
  EXPECT_NE(problem_of<CannotComplete>([&] { (void)media_module().create_movie(nowhere); }).find("a.mp4: "),
            std::string::npos);
}

}  // namespace
}  // namespace patinate
