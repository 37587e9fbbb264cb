/// \file
/// Which form the highlights of a surface have. Inside of unlighting only.
#pragma once

#include "capture/unlighting/unlight_work.h"

namespace patinate::capture {

/// Sets work.form, form_deviation, and how far highlights may be off it, to what foretells best what each lamp shows
/// from what the others do. Tried are both tints, then all pairs of a series of tails and of slants, the other middle,
/// how much texels differ from their neighborhood, and how much they are off the form; each with highlights, albedo and
/// normals of its own, on some 1,500 texels spread over the surface.
void choose_specular_form(UnlightWork& work, const RunControl& control);

}  // namespace patinate::capture
