//! Making section tables: what a new slab width, or a new view of a grid that is not cubic, costs.

use criterion::{Criterion, criterion_group, criterion_main};
use slabsplat_core::{Lookup, Normalization};
use slabsplat_kernel::{KERNEL_NAMES, SectionDesc, SectionTable, TableDesc, kernel_named};
use std::hint::black_box;

fn section_table(c: &mut Criterion) {
    let mut group = c.benchmark_group("section_table");
    for &name in KERNEL_NAMES {
        for &normalization in Normalization::ALL {
            let kernel = kernel_named(name).expect("the name is listed");
            let desc = SectionDesc {
                kernel: &*kernel,
                width: 1.0,
                kappa: 1.0,
                normalization,
                base_width: 0.5,
            };
            let table = TableDesc { sections: 128, radial_samples: 256, lookup: Lookup::Linear };
            group.bench_function(format!("{name}/{normalization}"), |b| {
                b.iter(|| SectionTable::new(black_box(&desc), table));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, section_table);
criterion_main!(benches);
