# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""The same diagnosis for many campaigns: find them, run them, put the answers together."""
