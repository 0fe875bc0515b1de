//! Fonts, colours and spaces of the window.

use eframe::egui::{Color32, Context, FontData, FontDefinitions, FontFamily, Theme, Visuals, vec2};
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
    // What is weak is still read: egui's own has a contrast of 2.5, people need 4.5.
    let visuals = |weak: u8, of_egui: Visuals| Visuals {
        weak_text_color: Some(Color32::from_gray(weak)),
        ..of_egui
    };
    context.set_visuals_of(Theme::Dark, visuals(135, Visuals::dark()));
    context.set_visuals_of(Theme::Light, visuals(105, Visuals::light()));
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
