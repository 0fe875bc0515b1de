// How many elements a dispatch has. Whoever includes this declares `counts`.

fn n_counted() -> u32 {
    if step.count_slot == NO_COUNT {
        return step.n_elements;
    }
    return min(counts[step.count_slot], step.n_elements);
}
