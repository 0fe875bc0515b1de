//! Flags of `[annotations]`.

use clap::Args;
use slabsplat::io::SceneFile;

#[derive(Args)]
#[command(next_help_heading = "Annotations")]
pub(super) struct AnnotationFlags {
    /// A line of text at the top of the picture
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    title: Option<String>,

    /// The box around everything, behind it, with coordinates in the file's units; a camera that is found
    /// leaves room for it
    #[arg(long)]
    axes: bool,

    /// A bar of a round length; in perspective it holds as deep as the camera's target
    #[arg(long)]
    scale_bar: bool,

    /// The colours of the first layer's visible values, or a legend of its labels
    #[arg(long)]
    color_bar: bool,

    /// The directions of the world, which turn with the camera: R, L, A, P, S, I of a body, else X, Y, Z
    #[arg(long)]
    orientation_marker: bool,

    /// Draw none of what the scene or picture has, but what flags name
    #[arg(long)]
    no_annotations: bool,
}

impl AnnotationFlags {
    /// Lays the flags over what a scene has drawn on its picture.
    pub(super) fn lay_over(&self, file: &mut SceneFile) -> anyhow::Result<()> {
        let mut finish = file.finish.clone();
        if self.no_annotations {
            finish.annotations = slabsplat::Annotations::default();
        }
        let annotations = &mut finish.annotations;
        annotations.title = self.title.clone().or(annotations.title.take());
        annotations.axes |= self.axes;
        annotations.scale_bar |= self.scale_bar;
        annotations.color_bar |= self.color_bar;
        annotations.orientation_marker |= self.orientation_marker;
        file.finish = finish.checked()?;
        Ok(())
    }
}
