"""The effects that come with the product: one file each, found by `vehicle.model.effect_catalogue`."""
