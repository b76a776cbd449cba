// A light map of 32-bit words in a 2-D array texture: word i of a texel is component i mod C of array layer ⌊i/C⌋,
// C = 1, 2 or 4, as many as hold all words where that is possible.
// Cost: one texture read a layer.
#import map::Tap
#import column::Column

@group(2) @binding(5) var map_word_texture: texture_2d_array<u32>;
@group(2) @binding(6) var map_word_store: texture_storage_2d_array<
#ifdef TEXEL_R32UINT
    r32uint,
#else ifdef TEXEL_RG32UINT
    rg32uint,
#else
    rgba32uint,
#endif
    write>;

fn store_words(column: Column, layer: u32, words: vec4u) {
    textureStore(map_word_store, column.texel, layer, words);
}

fn fetch_words(tap: Tap, layer: u32) -> vec4u {
    return textureLoad(map_word_texture, tap.texel, layer, 0);
}
