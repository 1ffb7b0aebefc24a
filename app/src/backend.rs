//! Chooses and makes the backend that the user or the machine asks for.
