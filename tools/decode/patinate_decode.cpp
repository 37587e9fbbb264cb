// patinate-decode FILE: decodes the images of one file, so that what goes wrong in a decoder stays in this process. It
// is started by patinate's own programs and speaks libcommon/image/decoder_wire.h on its standard input and output.
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include "libcommon/media/decoder_server.h"

int main(int argc, char** argv) {
  if (argc != 2 || ::isatty(STDOUT_FILENO) != 0) {
    std::fputs("patinate-decode FILE is started by patinate, to decode movies and camera RAW\n", stderr);
    return 2;
  }
  // Libraries may print to standard output; the answers go out under another number.
  const int out = ::dup(STDOUT_FILENO);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (out < 0 || nowhere < 0 || ::dup2(nowhere, STDOUT_FILENO) < 0) return 1;
  return patinate::serve_decoder(argv[1], STDIN_FILENO, out);
}
