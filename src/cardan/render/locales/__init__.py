"""Catalogues of texts, one .po file a language, as translators' tools write them."""
