// The three compositing models (SPEC §3).

const COMPOSITING_SEPARATE: u32 = 0u;
const COMPOSITING_ASSOCIATED: u32 = 1u;
const COMPOSITING_EXTINCTION: u32 = 2u;
