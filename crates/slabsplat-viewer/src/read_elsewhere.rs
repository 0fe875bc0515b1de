//! Files that a worker reads for its page: what is told to it, and how the volume comes back, as it lies in
//! memory.

use crate::handed::{Outside, VolumeHead, bytes_of, bytes_of_colors};
use serde::{Deserialize, Serialize};
use slabsplat::io::{
    FilesInMemory, LoadedColors, LoadedVolume, OpacitySource, ProgressCallback, VolumeChoices,
    VolumeFormat, VolumeOptions,
};

/// A file that is to be read, beside its bytes.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct ToRead {
    /// Its name, of which its format may depend.
    pub(crate) name: String,
    pub(crate) options: VolumeOptions,
}

impl ToRead {
    /// Reads it. `hear` hears which share of it is read.
    pub(crate) fn read(
        mut self,
        bytes: &[u8],
        hear: impl Fn(f64) + Send + Sync + 'static,
    ) -> Result<LoadedVolume, String> {
        self.options.progress = Some(ProgressCallback::new(move |read| hear(read.share())));
        let files = FilesInMemory::from_iter([(&*self.name, bytes)]);
        files.read_volume_with(&self.name, &self.options).map_err(|error| error.to_string())
    }
}

/// What was read of it, beside its samples and its colours.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct LoadedHead {
    volume: VolumeHead,
    format: String,
    warnings: Vec<String>,
    choices: VolumeChoices,
    colors: Option<ColorsHead>,
}

#[derive(Debug, Deserialize, Serialize)]
struct ColorsHead {
    has_alpha: bool,
    opacity_from: OpacitySource,
}

impl LoadedHead {
    pub(crate) fn of(loaded: &LoadedVolume) -> Self {
        let LoadedVolume { volume, format, acquisition, warnings, choices, colors, .. } = loaded;
        let voxels = colors.as_ref().and_then(|colors| colors.voxels.as_ref());
        let head = |&LoadedColors { has_alpha, opacity_from, .. }: &LoadedColors| ColorsHead {
            has_alpha,
            opacity_from,
        };
        Self {
            volume: VolumeHead::of(0, volume, voxels, *acquisition),
            format: format.name().to_owned(),
            warnings: warnings.clone(),
            choices: choices.clone(),
            colors: colors.as_ref().map(head),
        }
    }

    pub(crate) fn loaded(
        self,
        samples: Outside<'_>,
        colors: Outside<'_>,
    ) -> Result<LoadedVolume, String> {
        let mut loaded = LoadedVolume::computed(self.volume.volume(samples)?);
        let is_it = |format: &VolumeFormat| format.name() == self.format;
        if let Some(format) = VolumeFormat::ALL.iter().copied().find(is_it) {
            loaded.format = format;
        }
        loaded.acquisition = self.volume.acquisition()?;
        (loaded.warnings, loaded.choices) = (self.warnings, self.choices);
        let voxels = self.volume.colors(colors)?;
        loaded.colors = self.colors.map(|ColorsHead { has_alpha, opacity_from }| {
            LoadedColors::new(voxels, has_alpha, opacity_from)
        });
        Ok(loaded)
    }
}

/// A volume's samples, and its colours if it has any.
pub(crate) fn parts_of(loaded: &LoadedVolume) -> [&[u8]; 2] {
    let colors = loaded.colors.as_ref().and_then(|colors| colors.voxels.as_ref());
    [bytes_of(&loaded.volume), colors.map_or(&[], bytes_of_colors)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handed::WithBytes;
    use crate::handed::tests::outside;
    use std::sync::{Arc, Mutex};

    /// What comes back of a file, and what is read of it here.
    fn read(name: &str, bytes: &[u8], options: &VolumeOptions) -> [LoadedVolume; 2] {
        let to_read = ToRead { name: name.to_owned(), options: options.clone() };
        let told = serde_json::to_string(&WithBytes::ToRead(to_read)).unwrap();
        let WithBytes::ToRead(told) = serde_json::from_str(&told).unwrap() else {
            panic!("a file is to be read, not {told}");
        };
        let shares = Arc::new(Mutex::new(Vec::new()));
        let heard = shares.clone();
        let loaded = told.read(bytes, move |share| heard.lock().unwrap().push(share)).unwrap();
        assert_eq!(shares.lock().unwrap().last(), Some(&1.0), "all of {name} is read");
        let head = serde_json::to_string(&LoadedHead::of(&loaded)).unwrap();
        let head: LoadedHead = serde_json::from_str(&head).unwrap();
        let [samples, colors] = parts_of(&loaded);
        let back =
            outside(samples, |samples| outside(colors, |colors| head.loaded(samples, colors)));
        let files = FilesInMemory::from_iter([(name, bytes)]);
        [back.unwrap(), files.read_volume_with(name, options).unwrap()]
    }

    fn assert_same([back, expected]: [LoadedVolume; 2]) {
        assert_eq!(back.volume.grid(), expected.volume.grid());
        assert_eq!(back.volume.scaling(), expected.volume.scaling());
        assert_eq!(back.volume.samples(), expected.volume.samples());
        assert_eq!(back.format, expected.format);
        assert_eq!(back.acquisition, expected.acquisition);
        assert_eq!(back.warnings, expected.warnings);
        assert_eq!(back.choices, expected.choices);
        // Colours are equal only to copies of themselves.
        let facts = |loaded: &LoadedVolume| {
            let LoadedColors { voxels, has_alpha, opacity_from, .. } = loaded.colors.clone()?;
            Some((voxels.map(|voxels| voxels.samples().clone()), has_alpha, opacity_from))
        };
        assert_eq!(facts(&back), facts(&expected));
    }

    #[test]
    fn files_that_a_worker_reads_are_what_they_are_here() {
        let nrrd = |header: &str, n_bytes: usize| {
            let bytes = (0..n_bytes).map(|i| (i * i % 251) as u8);
            let text = format!("NRRD0004\n{header}\nendian: little\nencoding: raw\n\n");
            text.bytes().chain(bytes).collect::<Vec<u8>>()
        };
        let plain = "type: int16\ndimension: 3\nsizes: 2 3 4\nspace: right-anterior-superior\n\
                     space directions: (1,0.2,0) (0,1.3,0) (0,0.3,2)\nspace origin: (1,2,3)";
        let plain = nrrd(plain, 48);
        assert_same(read("a.nrrd", &plain, &VolumeOptions::default()));
        let colored = "type: uint8\ndimension: 4\nsizes: 4 2 3 4\n\
                       kinds: RGBA-color domain domain domain";
        let colored = nrrd(colored, 96);
        assert_same(read("a.nrrd", &colored, &VolumeOptions::default()));
        assert_same(read("a.nrrd", &colored, &VolumeOptions::default().channel(2)));
        let error = ToRead { name: "a.nrrd".to_owned(), options: VolumeOptions::default() }
            .read(&plain[..plain.len() - 1], |_| ())
            .unwrap_err();
        assert!(error.contains("a.nrrd"), "{error}");
    }
}
