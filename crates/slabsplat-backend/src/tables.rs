//! The tables of a layer, kept as long as the next frame can use them again.

use crate::{
    Cached, ColorSplats, DensitySplats, MergedSections, SectionSplats, SeparableDensities, Slabs,
    SmoothSections, Splats,
};
use slabsplat_core::{
    Cancelled, FrameHandle, Grid, KernelName, Lookup, Method, Normalization, RenderSettings,
    SliceOrder, View,
};
use slabsplat_kernel::{
    CubicSectionTable, ErrorBudget, FootprintShape, FootprintTable, Kernel, KernelTails,
    SectionDesc, SectionTable, SplitLevels, SplitView, TableDesc, TiltedSections,
};
use std::sync::Arc;

/// Tables of sections cost a millisecond or more, and seldom change from one frame to the next, so the last
/// ones are cached.
#[derive(Debug, Default)]
pub(crate) struct Tables {
    sections: Cached<TableKey, Arc<SectionTable>>,
    whole: Cached<TableKey, Arc<SectionTable>>,
    footprint: Cached<TableKey, Arc<FootprintTable>>,
    cubic: Cached<TableKey, Arc<CubicSectionTable>>,
    /// By the kernel's name.
    tails: Cached<KernelName, KernelTails>,
    tilted: Cached<TableKey, Option<Arc<TiltedSections>>>,
}

/// A layer that is about to be splatted.
pub(crate) struct LayerToSplat<'a> {
    pub(crate) kernel: &'a dyn Kernel,
    pub(crate) grid: &'a Grid,
    /// Of detail.
    pub(crate) level: u32,
    pub(crate) view: &'a View,
    pub(crate) shape: &'a FootprintShape,
    /// Widths in voxel steps of this layer.
    pub(crate) settings: RenderSettings,
    /// What sheets are of, if they are of slabs.
    pub(crate) slabs: Slabs,
    /// Whether a slab may have a share of them: a region cuts them, or meshes end rays.
    pub(crate) is_split: bool,
    /// For which its tables are made.
    pub(crate) frame: &'a FrameHandle,
}

/// Everything that the tables are made from.
#[derive(Clone, Debug, PartialEq)]
struct TableKey {
    kappa: f64,
    settings: RenderSettings,
}

impl TableKey {
    /// The sections by slabs of that width.
    fn sections_of(
        &self,
        kernel: &dyn Kernel,
        width: f64,
        frame: &FrameHandle,
    ) -> Result<Arc<SectionTable>, Cancelled> {
        let Self { kappa, ref settings } = *self;
        let desc = SectionDesc {
            kernel,
            width,
            kappa,
            normalization: settings.normalization,
            base_width: settings.base_slab_width,
        };
        let table = TableDesc {
            sections: settings.sections,
            radial_samples: settings.radial_samples,
            lookup: settings.lookup,
        };
        SectionTable::for_frame(&desc, table, frame).map(Arc::new)
    }
}

impl Tables {
    /// What a layer splats.
    ///
    /// # Errors
    /// If the frame is cancelled.
    pub(crate) fn splats(&mut self, layer: LayerToSplat<'_>) -> Result<Splats, Cancelled> {
        let LayerToSplat { kernel, grid, level, view, shape, settings, slabs, is_split, frame } =
            layer;
        let key = TableKey { kappa: rounded(shape.kappa), settings };
        let split_view = SplitView {
            layer_depth: shape.half_depth / grid.unit(),
            steepest_ray: view.steepest_ray(),
            is_cut: is_split,
            level,
        };
        let colors = match key.settings.method {
            Method::ImageAligned => ColorSplats::Sections(Box::new(SectionSplats {
                slabs,
                merged: self.merged_sections(kernel, &key, split_view, frame)?,
                tilted: self.tilted_sections(kernel, &key, shape),
                table: self.section_table(kernel, key, frame)?,
            })),
            Method::AxisAligned => ColorSplats::Slices {
                order: SliceOrder::new(grid, view.axes().forward),
                table: self.footprint_table(kernel, key),
            },
            Method::EverySample => ColorSplats::Voxels { table: self.footprint_table(kernel, key) },
            Method::PostClassified => {
                let densities = self.densities(kernel, key, slabs, frame)?;
                return Ok(Splats::Densities(Box::new(densities)));
            }
        };
        Ok(Splats::Colors(colors))
    }

    fn merged_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
        view: SplitView,
        frame: &FrameHandle,
    ) -> Result<Option<MergedSections>, Cancelled> {
        let tails = self.tails.made_of(key.settings.kernel.clone(), |_| KernelTails::of(kernel));
        let levels = SplitLevels::new(&key.settings, tails, view);
        if levels.are_all_last() {
            return Ok(None);
        }
        let table = self.whole_table(kernel, key, frame)?;
        Ok(Some(MergedSections { levels, table, budget: ErrorBudget::new(&key.settings) }))
    }

    /// Sections with all that lies before or behind a face.
    fn whole_table(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
        frame: &FrameHandle,
    ) -> Result<Arc<SectionTable>, Cancelled> {
        let table = self.whole.try_made_of(key.clone(), |key| {
            key.sections_of(kernel, 2.0 * kernel.radius() / key.kappa, frame)
        });
        table.cloned()
    }

    /// Of what the definition leaves to a table, only that is without one which no setting of tables changes.
    fn tilted_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
        shape: &FootprintShape,
    ) -> Option<Arc<TiltedSections>> {
        let settings = &key.settings;
        let reads_table = settings.lookup == Lookup::Nearest
            || settings.normalization != Normalization::None
            || !shape.is_tilted(kernel.radius());
        if reads_table {
            return None;
        }
        self.product_sections(kernel, key)
    }

    /// `None` if the kernel is no product.
    fn product_sections(
        &mut self,
        kernel: &dyn Kernel,
        key: &TableKey,
    ) -> Option<Arc<TiltedSections>> {
        let made = |key: &TableKey| TiltedSections::new(kernel, key.kappa).map(Arc::new);
        self.tilted.made_of(key.clone(), made).clone()
    }

    fn section_table(
        &mut self,
        kernel: &dyn Kernel,
        key: TableKey,
        frame: &FrameHandle,
    ) -> Result<Arc<SectionTable>, Cancelled> {
        let table = |key: &TableKey| key.sections_of(kernel, key.settings.slab_width, frame);
        self.sections.try_made_of(key, table).cloned()
    }

    /// Sections that were normalised would no longer measure lengths, so these never are.
    fn densities(
        &mut self,
        kernel: &dyn Kernel,
        TableKey { kappa, settings }: TableKey,
        slabs: Slabs,
        frame: &FrameHandle,
    ) -> Result<DensitySplats, Cancelled> {
        let settings = settings.normalization(Normalization::None).lookup(Lookup::Linear);
        let budget = ErrorBudget::of_densities(&settings);
        let key = TableKey { kappa, settings };
        let product = self.product_sections(kernel, &key);
        let separable = if product.is_some() && 0.0 < budget.separable() {
            Some(SeparableDensities { whole: self.whole_table(kernel, &key, frame)?, budget })
        } else {
            None
        };
        Ok(DensitySplats {
            shown: key.settings.mode.into(),
            slabs,
            smooth: match product {
                Some(sections) => SmoothSections::Product(sections),
                None => SmoothSections::Table(self.cubic_table(kernel, key.clone(), frame)?),
            },
            separable,
            table: self.section_table(kernel, key, frame)?,
        })
    }

    fn cubic_table(
        &mut self,
        kernel: &dyn Kernel,
        key: TableKey,
        frame: &FrameHandle,
    ) -> Result<Arc<CubicSectionTable>, Cancelled> {
        let table = |TableKey { kappa, settings }: &TableKey| {
            let desc = SectionDesc {
                kernel,
                width: settings.slab_width,
                kappa: *kappa,
                normalization: Normalization::None,
                base_width: settings.base_slab_width,
            };
            CubicSectionTable::for_frame(&desc, frame).map(Arc::new)
        };
        self.cubic.try_made_of(key, table).cloned()
    }

    fn footprint_table(&mut self, kernel: &dyn Kernel, key: TableKey) -> Arc<FootprintTable> {
        let table = |TableKey { kappa, settings }: &TableKey| {
            Arc::new(FootprintTable::new(kernel, *kappa, settings.radial_samples))
        };
        self.footprint.made_of(key, table).clone()
    }
}

/// A cubic grid has κ = 1 in every view, up to rounding errors, which must not cost a new table.
fn rounded(kappa: f64) -> f64 {
    let dropped_bits = 22;
    let up = kappa.to_bits() + (1 << (dropped_bits - 1));
    f64::from_bits(up & !((1 << dropped_bits) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_round_kappa_by_its_size() {
        for kappa in [1.0, 1.0_f64.next_down(), 1.0_f64.next_up()] {
            assert_eq!(rounded(kappa), 1.0);
        }
        for kappa in [1e-10, 0.3, 7.7e6] {
            assert!((rounded(kappa) / kappa - 1.0).abs() < 1e-9, "{kappa}");
        }
    }
}
