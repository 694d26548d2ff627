"""Plastic flow without hardening: what a rod does where its elastic stress exceeds the yield strength."""
