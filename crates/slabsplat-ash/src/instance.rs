//! The way into Vulkan: the loader, an instance, and what debugging tools it offers.

use crate::validation::{CHECKS, LAYER, Listener, messenger_info};
use ash::ext::{debug_utils, validation_features};
use ash::vk;
use slabsplat_gpu::Unavailable;
use std::ffi::{CStr, c_char};

/// An instance of Vulkan 1.2 or newer.
pub(crate) struct Instance {
    /// The functions of the instance.
    pub(crate) functions: ash::Instance,
    /// The newest version of Vulkan that may be used with it.
    pub(crate) version: u32,
    /// If objects can be named and commands labelled.
    pub(crate) has_labels: bool,
    messenger: Option<(debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Boxed, for the layer holds its address.
    listener: Option<Box<Listener>>,
    /// The loader's library, which has the code of everything above.
    entry: ash::Entry,
}

impl Instance {
    pub(crate) fn new(listener: Option<Listener>) -> Result<Self, Unavailable> {
        // SAFETY: the system's Vulkan loader has no unsound start-up that we could know of.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| {
            let reason = format!("there is no Vulkan loader on this machine ({error})");
            Unavailable { reason }
        })?;
        let version = usable_version(&entry)?;
        let offer = Offer::of(&entry, listener.is_some());
        let listener = listener.filter(|_| offer.has_layer && offer.has_labels).map(Box::new);
        let functions = create(&entry, version, &offer, listener.as_deref())?;
        let mut instance = Self {
            functions,
            version,
            has_labels: offer.has_labels,
            messenger: None,
            listener,
            entry,
        };
        instance.messenger = instance.messenger();
        Ok(instance)
    }

    /// If the validation layer watches.
    #[cfg(test)]
    pub(crate) fn is_validated(&self) -> bool {
        self.messenger.is_some()
    }

    /// Without one, a listener hears of the making and the end of the instance only; that is no reason
    /// to go without a device.
    fn messenger(&self) -> Option<(debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
        let info = messenger_info(self.listener.as_deref()?);
        let functions = debug_utils::Instance::new(&self.entry, &self.functions);
        // SAFETY: the extension is switched on wherever there is a listener, see `new`; the listener is
        // boxed and dropped after the messenger.
        let messenger = unsafe { functions.create_debug_utils_messenger(&info, None) }.ok()?;
        Some((functions, messenger))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((functions, messenger)) = self.messenger.take() {
            // SAFETY: it was made with this instance, and nobody else has it.
            unsafe { functions.destroy_debug_utils_messenger(messenger, None) };
        }
        // SAFETY: whatever was made with the instance holds it in an `Arc`, so it is gone.
        unsafe { self.functions.destroy_instance(None) };
    }
}

fn usable_version(entry: &ash::Entry) -> Result<u32, Unavailable> {
    // SAFETY: it needs nothing but a loaded library.
    let offered = unsafe { entry.try_enumerate_instance_version() }.ok().flatten();
    let offered = offered.unwrap_or(vk::API_VERSION_1_0);
    if offered < vk::API_VERSION_1_2 {
        let (major, minor) = (vk::api_version_major(offered), vk::api_version_minor(offered));
        let reason = format!("Vulkan 1.2 is needed, and the loader offers {major}.{minor}");
        return Err(Unavailable { reason });
    }
    // A version beyond what was read of the specification might forbid what is done here.
    Ok(if offered < vk::API_VERSION_1_3 { vk::API_VERSION_1_2 } else { vk::API_VERSION_1_3 })
}

/// What the machine has of what we could use.
struct Offer {
    has_layer: bool,
    has_labels: bool,
    has_checks: bool,
}

impl Offer {
    fn of(entry: &ash::Entry, wants_layer: bool) -> Self {
        let has_layer = wants_layer && has_layer(entry);
        let in_layer = |name| has_layer && has_extension(entry, Some(LAYER), name);
        Self {
            has_layer,
            has_labels: has_extension(entry, None, debug_utils::NAME)
                || in_layer(debug_utils::NAME),
            has_checks: in_layer(validation_features::NAME),
        }
    }
}

fn has_layer(entry: &ash::Entry) -> bool {
    // SAFETY: it needs nothing but a loaded library.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER))
}

fn has_extension(entry: &ash::Entry, layer: Option<&CStr>, name: &CStr) -> bool {
    // SAFETY: a layer that is asked for its extensions was found before.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(layer) };
    let extensions = extensions.unwrap_or_default();
    extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}

fn create(
    entry: &ash::Entry,
    version: u32,
    offer: &Offer,
    listener: Option<&Listener>,
) -> Result<ash::Instance, Unavailable> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"slabsplat")
        .engine_name(c"slabsplat")
        .api_version(version);
    let layers: &[*const c_char] = if listener.is_some() { &[LAYER.as_ptr()] } else { &[] };
    let mut extensions = Vec::new();
    if offer.has_labels {
        extensions.push(debug_utils::NAME.as_ptr());
    }
    let mut checks = vk::ValidationFeaturesEXT::default().enabled_validation_features(CHECKS);
    let mut messenger = listener.map(messenger_info);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    if let Some(messenger) = &mut messenger {
        info = info.push_next(messenger);
        if offer.has_checks {
            extensions.push(validation_features::NAME.as_ptr());
            info = info.push_next(&mut checks);
        }
    }
    let info = info.enabled_layer_names(layers).enabled_extension_names(&extensions);
    // SAFETY: layers and extensions were found on this machine, and all that `info` points at lives on.
    let created = unsafe { entry.create_instance(&info, None) };
    created.map_err(|result| Unavailable {
        reason: match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                "there is no Vulkan driver on this machine".to_owned()
            }
            other => format!("the Vulkan loader gave no instance: {other}"),
        },
    })
}
