//! Arms: the sensors that are compared.
