# Copyright 2026 hst_drive contributors
# SPDX-License-Identifier: Apache-2.0
"""
Frozen campaigns: a second, independent generator that is only used to score the diagnosis.

Its author knew the rig's datasheet, the paper and the format of logs, and neither the model nor
the other generator. It imports nothing of them. It stays as it is: an answer that comes out wrong
here is a reason to mend the diagnosis, never to change a campaign.

``python -m bench.frozen.make`` writes campaigns, ``python -m bench.frozen.score`` judges them.
"""
