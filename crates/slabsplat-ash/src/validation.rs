//! The validation layer, if somebody wants it and it is installed: its settings, and the way of its
//! messages to the caller.

use ash::vk;
use std::ffi::{CStr, c_void};

/// The layer's name.
pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What is called with every message.
pub(crate) type Listener = fn(&str);

/// Beside what the layer checks by default: barriers that are missing. Newer layers look at copies only,
/// unless `vk_layer_settings.txt` says `khronos_validation.syncval_shader_accesses_heuristic = true`.
pub(crate) const CHECKS: &[vk::ValidationFeatureEnableEXT] =
    &[vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

/// Messages that blame us wrongly.
const FALSE_ALARMS: &[&CStr] = &[
    // Strides on arrays in workgroup memory, which naga writes and no driver minds.
    c"VUID-StandaloneSpirv-None-10684",
];

/// Where the layer sends warnings and errors. Whatever is made with it must go before the listener does.
pub(crate) fn messenger_info(listener: &Listener) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    let address: *const Listener = listener;
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        .message_type(
            vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
        )
        .pfn_user_callback(Some(on_message))
        .user_data(address.cast_mut().cast())
}

/// # Safety
///
/// - `data` is null or what Vulkan promises it to be.
/// - `listener` is the address that [`messenger_info`] noted, and the listener is still there.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    listener: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the caller's promise on `data`.
    let Some(data) = (unsafe { data.as_ref() }) else { return vk::FALSE };
    // SAFETY: Vulkan sets both texts to null or to strings that outlive this call.
    let (id, text) = unsafe { (text_at(data.p_message_id_name), text_at(data.p_message)) };
    if FALSE_ALARMS.contains(&id) {
        return vk::FALSE;
    }
    // SAFETY: the caller's promise on `listener`.
    let listener = unsafe { *listener.cast::<Listener>() };
    listener(&text.to_string_lossy());
    // Never stops the call that the message is about.
    vk::FALSE
}

/// # Safety
///
/// - `text` is null or a string that ends with a zero byte and lives for `'a`.
unsafe fn text_at<'a>(text: *const std::ffi::c_char) -> &'a CStr {
    if text.is_null() {
        return c"";
    }
    // SAFETY: not null, and the caller's promise.
    unsafe { CStr::from_ptr(text) }
}
