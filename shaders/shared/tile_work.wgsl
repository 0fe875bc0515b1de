// What there is to do on a tile, and what became of it.

struct TileWork {
    // Its splats are the elements `begin .. end` of the sorted list.
    begin: u32,
    end: u32,
    n_splatted: u32,
    n_culled: u32,
    is_full: u32,
}
