# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The page, live: a server on this machine alone that switches effects and shows what they do."""
