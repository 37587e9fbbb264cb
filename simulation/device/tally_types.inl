// What is counted while a simulation runs on a device, in words; in the dialect of kernel_language.inl. The first are
// plain numbers, the others sums of 64 bits (tally.cl).

enum {
  kNumPieces = 0,  // Of the exchange of each phase,
  kNumWalks = 3,   // splats of each phase that have to be walked, and all their parts;
  kNumWalked = 6,
  kNumEndings = 9,     // gammatons whose trails are left there, after their ways and after responses.
  kHasOverflown = 11,  // There was too little room for pieces (1), a trail's tiles (2) or walks (4): what was done is
                       // wrong, and has to be done again with more.
  kNumTouched = 12,    // Tiles to be composed, and those whose normals are to be, in even and odd calls.
  kNumStale = 13,
  kFirstCount = 16,  // Sums from here on.
  kFirstMass = 32,
  kTallyWords = 32 + 2 * 8 * 8
};

// Phases of an iteration that exchange.
enum { kPhaseOfWays = 0, kPhaseOfContacts = 1, kPhaseOfResponses = 2 };

// Of TraceCounters,
enum { kSegments = 0, kContacts = 1, kEmitted = 2, kAbsorbed = 3, kLeft = 4, kRested = 5 };
// and of mass, each by material.
enum {
  kMassEmitted = 0,
  kMassAbsorbed = 1,
  kMassLeft = 2,
  kMassRested = 3,
  kMassPickedUp = 4,
  kMassDropped = 5,
  kMassMade = 6,
  kMassUsed = 7
};
