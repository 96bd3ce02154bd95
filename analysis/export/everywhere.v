(* ---- V falls while phi is not 0: sigma tends to 0, and where phi is a line the rest follows by a second form ---- *)

Lemma vanishes : forall (v v' s s' : R -> R) M, (forall t, 0 < t -> derivable_pt_lim v t (v' t)) ->
  (forall t, 0 < t -> v' t <= 0) -> (forall t, 0 < t -> 0 <= v t) -> (forall t, 0 < t -> derivable_pt_lim s t (s' t)) ->
  (forall t, 1 <= t -> Rabs (s' t) <= M) ->
  (forall e, 0 < e -> exists c, 0 < c /\ forall t, 0 < t -> e <= Rabs (s t) -> v' t <= - c) -> tends_to s 0.
Proof.
  intros v v' s s' M D neg pos Ds bound drop e epos.
  assert (M0 : 0 <= M) by (apply Rle_trans with (2 := bound 1 ltac:(lra)); apply Rabs_pos).
  destruct (drop (e / 2) ltac:(lra)) as [c [cpos low]]; set (h := e / (2 * (M + 1))).
  assert (hpos : 0 < h) by (apply Rdiv_lt_0_compat; lra).
  apply Classical_Prop.NNPP; intro none.
  assert (again : forall T, exists t, T <= t /\ 1 <= t /\ e <= Rabs (s t)).
  { intro T; apply Classical_Prop.NNPP; intro out; apply none; exists (Rmax T 1); intros t Ht; rewrite Rminus_0_r.
    apply Rnot_le_lt; intro L; apply out; exists t; pose proof (Rmax_l T 1); pose proof (Rmax_r T 1).
    repeat split; [lra|lra|exact L]. }
  assert (step : forall t, 1 <= t -> e <= Rabs (s t) -> v (t + h) <= v t - c * h).
  { intros t T B; destruct (MVT_cor2 v v' t (t + h)) as [u [E U]]; [lra|intros; apply D; lra|].
    assert (far : e / 2 <= Rabs (s u)).
    { destruct (MVT_cor2 s s' t u) as [r [F R0]]; [lra|intros; apply Ds; lra|].
      assert (G : Rabs (s u - s t) <= M * h).
      { rewrite F, Rabs_mult, (Rabs_right (u - t)) by lra; apply Rmult_le_compat; [apply Rabs_pos|lra|apply bound; lra|lra]. }
      assert (M * h <= e / 2).
      { unfold h; apply (Rmult_le_reg_r (2 * (M + 1))); [lra|].
        replace (M * (e / (2 * (M + 1))) * (2 * (M + 1))) with (M * e) by (field; lra); nra. }
      pose proof (Rabs_triang_inv (s t) (s u)) as X; rewrite Rabs_minus_sym in X; lra. }
    pose proof (low u ltac:(lra) far) as L; replace (t + h - t) with h in E by ring.
    pose proof (Rmult_le_compat_r h _ _ ltac:(lra) L); lra. }
  assert (many : forall N : nat, exists t, 1 <= t /\ v t <= v 1 - INR N * (c * h)).
  { induction N as [|N [t [T K]]]; [exists 1; cbn [INR]; lra|].
    destruct (again t) as [u [U1 [U2 U3]]]; exists (u + h); split; [lra|]; rewrite S_INR.
    pose proof (step u U2 U3); pose proof (nonincreasing v v' D neg t u ltac:(lra) U1); lra. }
  assert (ch : 0 < c * h) by now apply Rmult_lt_0_compat.
  destruct (archimed_cor1 (c * h / (v 1 + 1))) as [N [small Npos]].
  { apply Rdiv_lt_0_compat; [exact ch|pose proof (pos 1 ltac:(lra)); lra]. }
  destruct (many N) as [t [T K]]; pose proof (pos t ltac:(lra)); pose proof (pos 1 ltac:(lra)).
  apply lt_INR in Npos; cbn [INR] in Npos; apply (Rmult_lt_compat_l (INR N * (v 1 + 1))) in small; [|apply Rmult_lt_0_compat; lra].
  replace (INR N * (v 1 + 1) * / INR N) with (v 1 + 1) in small by (field; lra).
  replace (INR N * (v 1 + 1) * (c * h / (v 1 + 1))) with (INR N * (c * h)) in small by (field; lra); lra.
Qed.
Lemma tends_to_later : forall f T, tends_to (fun t => f (T + t)) 0 -> tends_to f 0.
Proof.
  intros f T H e epos; destruct (H e epos) as [U HU]; exists (T + U); intros t Ht.
  specialize (HU (t - T) ltac:(lra)); replace (T + (t - T)) with t in HU by ring; exact HU.
Qed.
Lemma later_flow : forall f T t l, derivable_pt_lim f (T + t) l -> derivable_pt_lim (fun t => f (T + t)) t l.
Proof.
  intros f T t l D e epos; destruct (D e epos) as [d H]; exists d; intros h h0 L; rewrite <- Rplus_assoc; now apply H.
Qed.

Definition stills (n : nat) (P now next : list (list Z)) (turn S : list term) (row psi : list Z) (N K : Z) : bool :=
  let (s, r) := (combine_forms row now, combine_forms row next) in
  (0 <? N)%Z && (0 <? K)%Z && nonneg n (bilinear P now now) &&
  nonneg n (times N (times (-1) (bilinear P now next ++ bilinear P next now) ++ times (-1) turn ++ times (-1) S)
            ++ [((-1)%Z, (psi, psi))]) &&
  nonneg n (times K (bilinear P now now ++ [(1%Z, (s, s)); (1%Z, (psi, psi))]) ++ [((-1)%Z, (r, r))]).

Theorem everywhere_in_time : forall n P now next turn S row psi N K Q rows g M L (z : R -> list R) (J : R -> R),
  stills n P now next turn S row psi N K = true -> falls_in_time n Q now next rows [] [] [(M, (g, g))] L = true ->
  (forall t, length (z t) = n) -> flows z now next ->
  (forall t, 0 < t -> derivable_pt_lim J t (value turn (z t))) -> (forall t, 0 < t -> 0 <= value S (z t)) ->
  (forall t, 0 < t -> 0 <= J t) ->
  (forall b, exists B, forall t, 0 < t -> J t <= b ->
    dot row (at_ now (z t)) * dot row (at_ now (z t)) + dot psi (z t) * dot psi (z t) <= B) ->
  (forall e, 0 < e -> exists c, 0 < c /\ forall t, 0 < t -> e <= Rabs (dot row (at_ now (z t))) -> c <= Rabs (dot psi (z t))) ->
  (exists d, 0 < d /\ forall t, 0 < t -> Rabs (dot row (at_ now (z t))) < d -> dot g (z t) = 0) ->
  forall r, In r rows -> tends_to (fun t => dot r (at_ now (z t))) 0.
Proof.
  intros n P now next turn S row psi N K Q rows g M L z J test second len F DJ class Jpos grows away [d [dpos line]] r I.
  unfold stills in test; rewrite !andb_true_iff, !Z.ltb_lt in test; destruct test as [[[[N0 K0] low] falls] speed].
  apply IZR_lt in N0, K0.
  set (v := fun t => value (bilinear P now now) (z t) + J t).
  set (v' := fun t => value (bilinear P now next) (z t) + value (bilinear P next now) (z t) + value turn (z t)).
  assert (D : forall t, 0 < t -> derivable_pt_lim v t (v' t)).
  { intros t T; apply (derivable_pt_lim_plus (fun t => value (bilinear P now now) (z t)) J); [now apply flow_bilinear|auto]. }
  assert (quick : forall t, 0 < t -> IZR N * v' t <= - (dot psi (z t) * dot psi (z t))).
  { intros t T; pose proof (nonneg_sound n _ (z t) falls (len t)) as A; pose proof (class t T) as C.
    repeat (rewrite value_app in A || rewrite value_times in A); cbn [value] in A.
    pose proof (Rmult_le_pos _ _ (Rlt_le _ _ N0) C); unfold v'; lra. }
  assert (neg : forall t, 0 < t -> v' t <= 0).
  { intros t T; pose proof (quick t T); pose proof (Rle_0_sqr (dot psi (z t))) as B; unfold Rsqr in B.
    apply (Rmult_le_reg_l (IZR N)); [exact N0|]; lra. }
  assert (V0 : forall t, 0 <= value (bilinear P now now) (z t)) by (intro t; apply (nonneg_sound n _ (z t) low (len t))).
  assert (lim : tends_to (fun t => dot row (at_ now (z t))) 0).
  { destruct (grows (v 1)) as [B HB].
    apply (vanishes v v' _ (fun t => dot row (at_ next (z t))) (1 + IZR K * (v 1 + B))); [exact D|exact neg| | | |].
    - intros t T; unfold v; pose proof (V0 t); pose proof (Jpos t T); lra.
    - intros t T; now apply (flow_row z now next).
    - intros t T; pose proof (nonneg_sound n _ (z t) speed (len t)) as A.
      repeat (rewrite value_app in A || rewrite value_times in A); cbn [value] in A; rewrite !dot_combine in A.
      pose proof (nonincreasing v v' D neg 1 t ltac:(lra) T) as C; pose proof (V0 t); pose proof (Jpos t ltac:(lra)).
      assert (X : value (bilinear P now now) (z t) <= v 1 /\ J t <= v 1) by (unfold v in C |- *; lra).
      assert (G := HB t ltac:(lra) ltac:(lra)); set (y := dot row (at_ next (z t))) in *.
      pose proof (Rmult_le_compat_l (IZR K) _ _ (Rlt_le _ _ K0) (Rplus_le_compat _ _ _ _ (proj1 X) G)) as E.
      pose proof (Rle_0_sqr (Rabs y - 1)) as R1; unfold Rsqr in R1.
      assert (R2 : Rabs y * Rabs y = y * y) by (rewrite <- Rabs_mult; apply Rabs_right; pose proof (Rle_0_sqr y) as R3; unfold Rsqr in R3; lra).
      pose proof (Rle_0_sqr (Rabs y)) as R4; unfold Rsqr in R4; lra.
    - intros e epos; destruct (away e epos) as [c [cpos W]]; exists (c * c / IZR N).
      split; [apply Rdiv_lt_0_compat; [now apply Rmult_lt_0_compat|exact N0]|].
      intros t T far; pose proof (quick t T) as O; pose proof (W t T far) as C.
      assert (E : c * c <= dot psi (z t) * dot psi (z t)).
      { apply Rle_trans with (Rabs (dot psi (z t)) * Rabs (dot psi (z t))); [apply Rmult_le_compat; lra|].
        rewrite <- Rabs_mult, Rabs_right; [lra|]; pose proof (Rle_0_sqr (dot psi (z t))) as R3; unfold Rsqr in R3; lra. }
      apply (Rmult_le_reg_l (IZR N)); [exact N0|].
      replace (IZR N * - (c * c / IZR N)) with (- (c * c)) by (field; lra); lra. }
  destruct (lim d dpos) as [T near]; set (T1 := Rmax T 0).
  pose proof (Rmax_l T 0) as A1; pose proof (Rmax_r T 0) as A2; fold T1 in A1, A2.
  apply (tends_to_later _ T1).
  apply (in_time n Q now next rows [] [] [(M, (g, g))] L (fun t => z (T1 + t)) (fun _ => 0) second); [intro; apply len| | | | |exact I].
  - clear - F A2; induction F as [|f h now next F0 F IH]; constructor; [|exact IH].
    intros t Ht; apply (later_flow (fun t => dot f (z t))), F0; lra.
  - intros; cbn; lra.
  - intros; cbn; apply derivable_pt_lim_const.
  - intros t Ht; cbn [value]; rewrite line; [lra|lra|]; specialize (near (T1 + t) ltac:(lra)); now rewrite Rminus_0_r in near.
Qed.

(* An integral of what has the sign of its argument, and is at least m away from d. *)
Lemma integral_grows : forall Phi phi m d, integral_of Phi phi -> 0 <= d -> 0 <= m -> (forall y, 0 <= y * phi y) ->
  (forall y, d <= Rabs y -> m <= Rabs (phi y)) -> forall y, 0 <= Phi y /\ m * (Rabs y - d) <= Phi y.
Proof.
  intros Phi phi m d [P0 D] d0 m0 sign big.
  assert (up : forall s t, 0 <= s -> s <= t -> Phi s <= Phi t).
  { intros s t S0 [L|<-]; [|lra]; destruct (MVT_cor2 Phi phi s t L (fun x _ => D x)) as [c [E C]].
    pose proof (sign c); assert (0 <= phi c) by nra; assert (0 <= phi c * (t - s)) by (apply Rmult_le_pos; lra); lra. }
  assert (down : forall s t, s <= t -> t <= 0 -> Phi t <= Phi s).
  { intros s t [L|<-] T0; [|lra]; destruct (MVT_cor2 Phi phi s t L (fun x _ => D x)) as [c [E C]].
    pose proof (sign c); assert (phi c <= 0) by nra; assert (phi c * (t - s) <= 0) by nra; lra. }
  intro y; destruct (Rle_or_lt 0 y) as [Y|Y].
  - pose proof (up 0 y ltac:(lra) Y); rewrite P0 in *; split; [assumption|]; rewrite Rabs_right by lra.
    destruct (Rle_or_lt y d) as [L|L]; [nra|].
    destruct (MVT_cor2 Phi phi d y L (fun x _ => D x)) as [c [E C]]; pose proof (up 0 d ltac:(lra) d0).
    pose proof (big c ltac:(rewrite Rabs_right; lra)) as B; pose proof (sign c); assert (0 <= phi c) by nra.
    rewrite Rabs_right in B by lra; rewrite P0 in *.
    assert (m * (y - d) <= phi c * (y - d)) by (apply Rmult_le_compat_r; lra); lra.
  - pose proof (down y 0 ltac:(lra) ltac:(lra)); rewrite P0 in *; split; [assumption|]; rewrite Rabs_left by lra.
    destruct (Rle_or_lt (- d) y) as [L|L]; [nra|].
    destruct (MVT_cor2 Phi phi y (- d) L (fun x _ => D x)) as [c [E C]]; pose proof (down (- d) 0 ltac:(lra) ltac:(lra)).
    pose proof (big c ltac:(rewrite Rabs_left; lra)) as B; pose proof (sign c); assert (phi c <= 0) by nra.
    rewrite Rabs_left1 in B by lra; rewrite P0 in *.
    assert (m * (- d - y) <= - phi c * (- d - y)) by (apply Rmult_le_compat_r; lra); lra.
Qed.

(* ---- What holds of a nonlinearity with a line around 0, from one cut to the next ---- *)

Lemma sector_right : forall u y p, 0 <= y -> 0 <= p -> p <= u * y -> 0 * (y * y) <= y * p <= u * (y * y).
Proof.
  intros u y p Y P U; pose proof (Rmult_le_pos y p Y P); pose proof (Rmult_le_pos y (u * y - p) Y ltac:(lra)); lra.
Qed.
Lemma sector_left : forall u y p, y <= 0 -> p <= 0 -> u * y <= p -> 0 * (y * y) <= y * p <= u * (y * y).
Proof.
  intros u y p Y P U; pose proof (Rmult_le_pos (- y) (- p) ltac:(lra) ltac:(lra)).
  pose proof (Rmult_le_pos (- y) (p - u * y) ltac:(lra) ltac:(lra)); lra.
Qed.
Lemma far_right : forall d m y p, 0 <= y -> (d <= y -> m <= p) -> d <= Rabs y -> m <= Rabs p.
Proof. intros d m y p Y H A; rewrite Rabs_right in A by lra; pose proof (Rle_abs p); specialize (H A); lra. Qed.
Lemma far_left : forall d m y p, y <= 0 -> (y <= - d -> p <= - m) -> d <= Rabs y -> m <= Rabs p.
Proof.
  intros d m y p Y H A; rewrite Rabs_left1 in A by lra; pose proof (Rle_abs (- p)) as B; rewrite Rabs_Ropp in B.
  specialize (H ltac:(lra)); lra.
Qed.
Lemma small_by : forall q d y, 0 < q -> Rabs (q * y) < q * d -> Rabs y <= d.
Proof. intros q d y Q H; rewrite Rabs_mult, (Rabs_right q) in H by lra; apply (Rmult_le_reg_l q); lra. Qed.
Lemma away_by : forall (phi : R -> R) d m k q, (forall y, Rabs y <= d -> phi y = k * y) ->
  (forall y, d <= Rabs y -> m <= Rabs (phi y)) -> 0 < m -> 0 < k -> 0 < q ->
  forall e, 0 < e -> exists c, 0 < c /\ forall y, e <= Rabs (q * y) -> c <= Rabs (phi y).
Proof.
  intros phi d m k q line away mp kp qp e epos; exists (Rmin m (k * (e / q))).
  assert (eq : 0 < e / q) by now apply Rdiv_lt_0_compat.
  split; [apply Rmin_glb_lt; [exact mp|now apply Rmult_lt_0_compat]|]; intros y Y.
  pose proof (Rmin_l m (k * (e / q))); pose proof (Rmin_r m (k * (e / q))).
  destruct (Rle_or_lt d (Rabs y)) as [L|L]; [pose proof (away y L); lra|].
  rewrite Rabs_mult, (Rabs_right q) in Y by lra; rewrite (line y), Rabs_mult, (Rabs_right k) by lra.
  assert (F : e / q <= Rabs y) by (apply (Rmult_le_reg_l q); [exact qp|replace (q * (e / q)) with e by (field; lra); exact Y]).
  pose proof (Rmult_le_compat_l k _ _ (Rlt_le _ _ kp) F); lra.
Qed.
Lemma grows_by : forall (Phi phi : R -> R) m d u c q b y, in_sector 0 u phi -> 0 < c -> 0 < m -> 0 <= d ->
  m * (Rabs y - d) <= Phi y -> c * Phi y + 0 <= b ->
  q * y * (q * y) + phi y * phi y <= (q * q + u * u) * ((d + b / (c * m)) * (d + b / (c * m))).
Proof.
  intros Phi phi m d u c q b y [Z H] cp mp d0 low high; specialize (H y).
  assert (cm : 0 < c * m) by now apply Rmult_lt_0_compat.
  assert (A : Rabs y <= d + b / (c * m)).
  { apply (Rmult_le_reg_l (c * m)); [exact cm|].
    replace (c * m * (d + b / (c * m))) with (c * m * d + b) by (field; lra).
    pose proof (Rmult_le_compat_l c _ _ (Rlt_le _ _ cp) low); lra. }
  assert (B : y * y <= (d + b / (c * m)) * (d + b / (c * m))).
  { replace (y * y) with (Rabs y * Rabs y) by (rewrite <- Rabs_mult; apply Rabs_right; pose proof (Rle_0_sqr y) as S0; unfold Rsqr in S0; lra).
    apply Rmult_le_compat; try assumption; apply Rabs_pos. }
  assert (C : phi y * phi y <= u * u * (y * y)).
  { destruct (Req_dec y 0) as [->|N]; [rewrite Z; lra|]; assert (P : 0 < y * y) by now apply Rsqr_pos_lt.
    assert (E : y * phi y * (y * phi y) <= u * (y * y) * (u * (y * y))) by (apply Rmult_le_compat; lra).
    apply (Rmult_le_reg_l (y * y)); [exact P|]; lra. }
  pose proof (Rle_0_sqr q) as Q; pose proof (Rle_0_sqr u) as U; unfold Rsqr in Q, U.
  pose proof (Rmult_le_compat_l (q * q + u * u) _ _ ltac:(lra) B); lra.
Qed.
