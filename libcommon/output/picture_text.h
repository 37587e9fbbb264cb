/// \file
/// Text in pictures.
#pragma once

#include <string>

#include "patinate/image/image.h"

namespace patinate {

enum class TextPlace { Left, Middle, Right };

/// Draws a line into a box of a picture, halfway up; letters shrink where it is too long.
/// @param text  Printable ASCII; anything else is drawn as `?`. @param x,y,width,height  Of the box, inside the
/// picture.
/// @param letter_px  Height of capital letters. @param ink  Linear gray.
void draw_text(ImageF& picture, const std::string& text, int x, int y, int width, int height, int letter_px, float ink,
               TextPlace place = TextPlace::Middle);

}  // namespace patinate
