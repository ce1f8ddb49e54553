# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""Generator of measured campaigns with known hidden physics; it knows nothing of the product."""

from .campaign import Campaign, make_campaign, write_campaign
from .catalogue import EFFECTS, OUTSIDE

__all__ = ['Campaign', 'EFFECTS', 'OUTSIDE', 'make_campaign', 'write_campaign']
