//! The channels of a layer's file, each with a mark if a layer shows it.

use crate::state::Document;
use eframe::egui::{ScrollArea, Ui};

/// A channel of a layer's file that is to be a layer, too; `None` for colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WantedChannel {
    pub(crate) layer_idx: usize,
    pub(crate) channel: Option<usize>,
}

/// Height of the list, in points: of more channels it is scrolled.
const MAX_HEIGHT: f32 = 130.0;

/// Shows the list, and takes layers away whose mark is. The channel that is to be added.
pub(crate) fn show(
    ui: &mut Ui,
    document: &mut Document,
    layer_idx: usize,
) -> Option<WantedChannel> {
    let channels = document.channels(layer_idx);
    let (mut wanted, mut removed) = (None, None);
    let list = ScrollArea::vertical().id_salt("channels").max_height(MAX_HEIGHT);
    let row_height = ui.spacing().interact_size.y;
    list.show_rows(ui, row_height, channels.len(), |ui, rows| {
        for channel in &channels[rows] {
            let mut is_shown = channel.layer_idx.is_some();
            let can_change = channel.layer_idx.is_none_or(|idx| document.can_do_without(idx));
            ui.add_enabled_ui(can_change, |ui| {
                if ui.checkbox(&mut is_shown, &channel.name).changed() {
                    removed = channel.layer_idx;
                    let of_channel = WantedChannel { layer_idx, channel: channel.channel };
                    wanted = is_shown.then_some(of_channel);
                }
            });
        }
    });
    if let Some(layer_idx) = removed {
        document.remove_layer(layer_idx);
    }
    wanted
}
