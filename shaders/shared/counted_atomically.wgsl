// How many elements a dispatch has whose threads count, too. Whoever includes this declares `counts`, of atomics.

fn n_counted() -> u32 {
    if step.count_slot == NO_COUNT {
        return step.n_elements;
    }
    return min(atomicLoad(&counts[step.count_slot]), step.n_elements);
}
