//! Fonts, colours and spaces of the window.

use eframe::egui::{Context, FontData, FontDefinitions, FontFamily, Theme, Visuals, vec2};
use std::sync::Arc;

/// Dresses a window: in the font that annotations are written with, which is in the program anyway.
pub(crate) fn dress(context: &Context) {
    const NAME: &str = "DejaVu Sans";
    let mut fonts = FontDefinitions::empty();
    let font = FontData::from_static(slabsplat::annotations::FONT);
    fonts.font_data.insert(NAME.to_owned(), Arc::new(font));
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.insert(family, vec![NAME.to_owned()]);
    }
    context.set_fonts(fonts);
    context.set_visuals_of(Theme::Dark, Visuals::dark());
    context.set_visuals_of(Theme::Light, Visuals::light());
    for theme in [Theme::Dark, Theme::Light] {
        context.style_mut_of(theme, |style| {
            style.spacing.item_spacing = vec2(6.0, 4.0);
            style.spacing.slider_width = 70.0;
            for font in style.text_styles.values_mut() {
                font.size *= 0.94;
            }
        });
    }
}
