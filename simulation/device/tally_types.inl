// What is counted while a simulation runs on a device, in words; in the dialect of kernel_language.inl. The first are
// plain numbers, the others sums of 64 bits (exact_sums.cl).

enum {
  kNumPieces = 0,      // Of the exchange of each phase,
  kNumEndings = 3,     // gammatons whose trails are left there, after their ways and after responses,
  kNumCut = 5,         // contacts near seams.
  kHasOverflown = 6,   // There was too little room: what was done is wrong, and has to be done again with more.
  kNumTouched = 7,     // Tiles to be composed, and those whose normals are to be, in even and odd calls.
  kNumStale = 8,
  kFirstCount = 16,    // Sums from here on.
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
