//! Scenes in a browser: a server that opens a scene, renders what its viewers ask for, and sends pictures.
